#include "voxelserver/make/worlds/overlay/overlay_world.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/geo/geojson.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "common/voxel/fingerprint.hpp"

namespace terravox::overlay {
namespace {

using util::number_text;

/// The height of an object's top, as it was given.
struct Height {
    double metres = 0;
    bool is_above_ground = false;
};

/// Reads the additions to one world.
class AdditionReader {
public:
    AdditionReader(voxel::World& world, const std::stop_token& stop)
        : m_world(world), m_info(world.info()), m_stop(stop) {}

    void read(const std::string& text) {
        m_text = text;
        const std::string ending = util::lower_extension(text);
        if (ending == ".geojson" || ending == ".json")
            read_file();
        else
            read_box();
    }
    [[nodiscard]] std::vector<AddedObject> take() { return std::move(m_objects); }
    /// Identifies the objects: how many there are, and a hash of their corners and tops.
    [[nodiscard]] std::string identity() const {
        return std::to_string(m_objects.size()) + " objects " +
               voxel::to_hex(m_identity.fingerprint());
    }

private:
    [[noreturn]] void refuse(const std::string& what) const {
        throw util::UsageError("add {}: {}", m_text, what);
    }

    void read_box() {
        std::string numbers = m_text;
        Height height;
        if (const std::size_t last = numbers.rfind(',') + 1;
            last > 0 && last < numbers.size() && numbers[last] == '+') {
            height.is_above_ground = true;
            numbers.erase(last, 1);
        }
        std::array<double, 5> values{};
        const char* at = numbers.data();
        const char* end = at + numbers.size();
        for (std::size_t i = 0; i < values.size(); ++i) {
            const auto [next, failed] = std::from_chars(at, end, values[i]);
            const bool is_last = i + 1 == values.size();
            if (failed != std::errc{} || !std::isfinite(values[i]) ||
                (is_last ? next != end : next == end || *next != ','))
                refuse(std::string("no object; allowed: ") + kAdditionForms);
            at = is_last ? next : next + 1;
        }
        const auto [west, south, east, north, metres] = values;
        if (!(west < east && south < north))
            refuse("it is empty or upside down; allowed: west,south,east,north");
        height.metres = metres;
        const Footprint::Ring ring = {in_voxels(west, south), in_voxels(east, south),
                                      in_voxels(east, north), in_voxels(west, north)};
        (void)add({ring}, height, false);
    }

    void read_file() {
        if (m_info.crs_wkt.empty())
            refuse(
                "this world has no CRS to place its objects in; allowed: x0,z0,x1,z1,TOP in "
                "voxels");
        const auto shapes = geo::read_geojson(m_text, geo::Crs::from_wkt(m_info.crs_wkt), m_stop);
        std::size_t lamps_left_out = 0;
        std::size_t flat = 0;
        for (const geo::Shape& shape : shapes) {
            const std::string name = "feature " + std::to_string(shape.feature);
            if (shape.kind == geo::ShapeKind::kLine)
                refuse(name + " is neither a polygon nor a point");
            const bool is_lamp = shape.kind == geo::ShapeKind::kPoint;
            const double top = shape.metres("top");
            Height height =
                std::isnan(top) ? Height{shape.metres("height"), true} : Height{top, false};
            if (is_lamp && std::isnan(height.metres))
                height.metres = kLampHeight_m;
            if (std::isnan(height.metres))
                refuse(name + " has no number 'top' or 'height', in metres");
            flat += height.is_above_ground && !(height.metres > 0) ? 1 : 0;
            std::vector<Footprint::Ring> rings;
            for (const auto& part : shape.parts) {
                Footprint::Ring& ring = rings.emplace_back();
                for (const geo::Shape::Position& p : part)
                    ring.push_back(in_voxels(p[0], p[1]));
            }
            if (is_lamp)
                rings = {find_column(rings.front().front())};
            if (!add(std::move(rings), height, is_lamp))
                ++lamps_left_out;
        }
        if (shapes.empty())
            refuse("it holds neither a polygon nor a point");
        if (lamps_left_out == shapes.size())
            refuse_place();
        if (flat > 0)
            util::log_warn("add {}: {} of {} objects have no 'height' above 0, and so show nothing",
                           m_text, flat, shapes.size());
        if (lamps_left_out > 0)
            util::log_warn("add {}: points left out, where there are no data: {}", m_text,
                           lamps_left_out);
    }

    /// The voxels in which a point lies.
    [[nodiscard]] static Footprint::Ring find_column(const Footprint::Point& point) {
        const double x = std::floor(point[0]);
        const double z = std::floor(point[1]);
        return {{x, z}, {x + 1, z}, {x + 1, z + 1}, {x, z + 1}};
    }

    [[nodiscard]] Footprint::Point in_voxels(double x, double y) const {
        if (m_info.crs.empty())
            return {x, y};
        return {x / m_info.crs_units_per_voxel, -y / m_info.crs_units_per_voxel};
    }

    /// @return false for a lamp where there are no data: a town has more lamps than the data, while
    /// a plan is refused there
    [[nodiscard]] bool add(std::vector<Footprint::Ring> rings, Height height, bool is_lamp) {
        // The ground below an object may take making a box.
        if (m_stop.stop_requested())
            throw util::Error("add {}: interrupted", m_text);
        if (m_objects.size() == kMaxObjects)
            refuse("more than " + std::to_string(kMaxObjects) + " objects");
        std::optional<Footprint> footprint;
        try {
            footprint.emplace(std::move(rings));
        } catch (const std::invalid_argument& e) {
            refuse(e.what());
        }
        if (!is_within_data(*footprint)) {
            if (is_lamp)
                return false;
            refuse_place();
        }
        double top = height.metres / m_info.voxel_m;
        if (height.is_above_ground) {
            const auto ground = ground_below(*footprint, is_lamp);
            if (!ground && is_lamp)
                return false;
            if (!ground)
                refuse("there are no data in its middle; allowed: TOP, a height of its own");
            top += *ground;
        }
        constexpr double kHighest_m = 20'000;
        if (!(std::abs(top * m_info.voxel_m) <= kHighest_m))
            refuse("a top at " + number_text(top * m_info.voxel_m) + " m; allowed: up to " +
                   number_text(kHighest_m));
        for (const Footprint::Ring& ring : footprint->rings()) {
            for (const Footprint::Point& corner : ring) {
                m_identity.add(corner[0]);
                m_identity.add(corner[1]);
            }
            m_identity.add(std::uint64_t{ring.size()});
        }
        m_identity.add(top);
        m_identity.add(std::uint8_t{is_lamp});
        m_objects.push_back({std::move(*footprint), top, is_lamp});
        return true;
    }

    [[nodiscard]] bool is_within_data(const Footprint& footprint) const {
        const voxel::VoxelBounds& b = m_info.bounds;
        const Footprint::Point low = footprint.min();
        const Footprint::Point high = footprint.max();
        return low[0] >= b.min[0] && high[0] <= b.max[0] && low[1] >= b.min[2] &&
               high[1] <= b.max[2];
    }

    [[noreturn]] void refuse_place() const {
        const voxel::VoxelBounds& b = m_info.bounds;
        const bool is_placed = !m_info.crs.empty();
        const double unit = is_placed ? m_info.crs_units_per_voxel : 1;
        refuse("it lies outside of the data; allowed: within " + number_text(b.min[0] * unit) +
               "," + number_text(is_placed ? -b.max[2] * unit : b.min[2]) + "," +
               number_text(b.max[0] * unit) + "," +
               number_text(is_placed ? -b.min[2] * unit : b.max[2]));
    }

    /// A lamp may stand on a roof; what is planned takes the place of houses.
    [[nodiscard]] std::optional<std::int32_t> ground_below(const Footprint& footprint,
                                                           bool is_lamp) const {
        const auto x = static_cast<std::int32_t>(std::floor(footprint.middle()[0]));
        const auto z = static_cast<std::int32_t>(std::floor(footprint.middle()[1]));
        if (!is_lamp)
            return find_ground(m_world, x, z);
        const auto found = find_surface(m_world, x, z);
        return found ? std::optional(found->top) : std::nullopt;
    }

    voxel::World& m_world;
    const voxel::WorldInfo& m_info;
    const std::stop_token& m_stop;
    std::string m_text;
    voxel::ByteWriter m_identity;
    std::vector<AddedObject> m_objects;
};

}  // namespace

std::unique_ptr<voxel::World> with_additions(std::unique_ptr<voxel::World> world,
                                             std::span<const std::string> additions,
                                             const std::stop_token& stop) {
    if (additions.empty())
        return world;
    AdditionReader reader(*world, stop);
    for (const std::string& text : additions)
        reader.read(text);
    return std::make_unique<OverlayWorld>(std::move(world), reader.take(), reader.identity());
}

}  // namespace terravox::overlay
