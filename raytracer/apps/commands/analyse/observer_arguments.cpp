#include "raytracer/apps/commands/analyse/analyse_run.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "common/geo/geojson.hpp"
#include "common/util/error.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"

namespace terravox::commands {
namespace {

constexpr std::string_view kAboveGround = ",above-ground";

using Observers = std::vector<analyse::Observer>;
using Position = geo::Shape::Position;

void check_count(std::size_t count) {
    if (count < 1 || count > scene::PointList::kMaxPoints)
        throw util::UsageError(
            "analyse sight: " + std::to_string(count) + " observers; allowed: 1 to " +
            std::to_string(scene::PointList::kMaxPoints) + ", by --observer and --observers");
}

/// Reads the observers of one file.
class ObserverFile {
public:
    ObserverFile(std::string file, const voxel::WorldInfo& world, double step_m, Observers& out)
        : m_file(std::move(file)), m_world(world), m_step(step_m / world.voxel_m), m_out(out) {}

    void read() {
        if (m_world.crs_wkt.empty())
            throw util::UsageError("analyse sight: --observers " + m_file +
                                   ": this world has no CRS to place them in; allowed: --observer");
        for (const geo::Shape& shape :
             geo::read_geojson(m_file, geo::Crs::from_wkt(m_world.crs_wkt))) {
            if (shape.kind == geo::ShapeKind::kPolygon)
                throw util::UsageError("analyse sight: --observers " + m_file + ": feature " +
                                       std::to_string(shape.feature) +
                                       " is a polygon; allowed: points and lines");
            const std::vector<Position>& way = shape.parts.front();
            add(shape, way.front());
            for (std::size_t i = 1; i < way.size(); ++i)
                add_side(shape, way[i - 1], way[i]);
        }
    }

private:
    /// Adds what follows the beginning of a line's side, up to its end, evenly spaced.
    void add_side(const geo::Shape& shape, const Position& from, const Position& to) {
        const double units = m_world.crs_units_per_voxel;
        const double length = std::hypot(to[0] - from[0], to[1] - from[1]) / units;
        const double steps = std::max(1.0, std::ceil(length / m_step));
        check_count(m_out.size() + static_cast<std::size_t>(std::min(steps, 1e6)));
        for (double i = 1; i <= steps; ++i) {
            const double share = i / steps;
            Position at{};
            for (std::size_t a = 0; a < 3; ++a)
                at[a] = from[a] + (to[a] - from[a]) * share;
            add(shape, at);
        }
    }

    void add(const geo::Shape& shape, const Position& at) {
        constexpr double kEyes_m = 1.6;
        check_count(m_out.size() + 1);
        analyse::Observer observer;
        observer.x = at[0] / m_world.crs_units_per_voxel;
        observer.z = -at[1] / m_world.crs_units_per_voxel;
        const double height = shape.metres("height");
        if (std::isnan(height) && !std::isnan(at[2])) {
            observer.height_m = at[2];
        } else {
            observer.base = analyse::HeightBase::kGround;
            observer.height_m = std::isnan(height) ? kEyes_m : height;
        }
        observer.text = std::to_string(m_out.size() + 1) + ", of feature " +
                        std::to_string(shape.feature) + " of " + m_file;
        m_out.push_back(observer);
    }

    const std::string m_file;
    const voxel::WorldInfo& m_world;
    const double m_step;  ///< level-0 voxels
    Observers& m_out;
};

}  // namespace

analyse::Observer parse_observer(const std::string& text, const voxel::WorldInfo& world) {
    analyse::Observer out;
    out.text = text;
    std::string numbers = text;
    const std::size_t height = numbers.rfind(',') + 1;
    if (numbers.ends_with(kAboveGround)) {
        out.base = analyse::HeightBase::kGround;
        numbers.resize(numbers.size() - kAboveGround.size());
    } else if (height < numbers.size() && numbers[height] == '+') {
        out.base = analyse::HeightBase::kTop;
        numbers.erase(height, 1);
    }
    const auto values = list_numbers("analyse sight", "--observer", numbers, 3, kObserverForms);
    if (values.size() != 3)
        throw util::UsageError("analyse sight: --observer ''; allowed: " +
                               std::string(kObserverForms));
    const bool is_placed = !world.crs.empty();
    const double unit = is_placed ? world.crs_units_per_voxel : 1;
    out.x = values[0] / unit;
    out.z = is_placed ? -values[1] / unit : values[1];
    out.height_m = values[2];
    return out;
}

std::vector<analyse::Observer> parse_observers(const ObserverArguments& args,
                                               const voxel::WorldInfo& world) {
    Observers out;
    for (const std::string& text : args.texts)
        out.push_back(parse_observer(text, world));
    for (const std::string& file : args.files)
        ObserverFile(file, world, args.step_m, out).read();
    check_count(out.size());
    return out;
}

}  // namespace terravox::commands
