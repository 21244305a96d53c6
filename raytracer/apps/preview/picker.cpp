#include "raytracer/apps/preview/picker.hpp"

#include <array>
#include <cstdio>
#include <utility>

#include "common/geo/crs.hpp"
#include "common/thread/start_threads.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/tiles/square_grid.hpp"
#include "raytracer/core/walk/walker.hpp"

namespace terravox::preview {
namespace {

// Ref: ASPRS, "LAS Specification 1.4 - R15", table 17.
constexpr std::array<const char*, 23> kStandardClasses{"never classified",
                                                       "unclassified",
                                                       "ground",
                                                       "low vegetation",
                                                       "medium vegetation",
                                                       "high vegetation",
                                                       "building",
                                                       "low noise",
                                                       "reserved",
                                                       "water",
                                                       "rail",
                                                       "road surface",
                                                       "reserved",
                                                       "wire guard",
                                                       "wire conductor",
                                                       "transmission tower",
                                                       "wire connector",
                                                       "bridge deck",
                                                       "high noise",
                                                       "overhead structure",
                                                       "ignored ground",
                                                       "snow",
                                                       "temporal exclusion"};

template <class... Values>
std::string text(const char* format, Values... values) {
    std::array<char, 160> out{};
    std::snprintf(out.data(), out.size(), format, values...);
    return out.data();
}

}  // namespace

std::vector<PickedFact> facts_of(const Picked& picked, const voxel::WorldInfo& world) {
    std::vector<PickedFact> out;
    out.push_back({"voxel", text("%d, %d, %d", picked.voxel.x, picked.voxel.y, picked.voxel.z) +
                                (picked.level > 0 ? text(" of level %d", picked.level) : "")});
    const core::Vec3 p = picked.point;
    const double easting = p.x * world.crs_units_per_voxel;
    const double northing = -p.z * world.crs_units_per_voxel;
    const double height_m = p.y * world.voxel_m;
    if (!world.crs.empty()) {
        out.push_back({world.crs, text("%.2f, %.2f", easting, northing)});
        try {
            const geo::LatLon at =
                geo::to_lat_lon(geo::Crs::from_wkt(world.crs_wkt), easting, northing);
            out.push_back({"lat, lon", text("%.7f, %.7f", at.lat_deg, at.lon_deg)});
        } catch (const util::Error&) {
            out.push_back({"lat, lon", "not defined here"});
        }
    } else {
        out.push_back(
            {"world", text("%.2f m east, %.2f m south", p.x * world.voxel_m, p.z * world.voxel_m)});
    }
    out.push_back({"height", text("%.2f m", height_m)});
    out.push_back({"distance", text("%.1f m", picked.distance_m)});
    if (picked.hole) {
        out.push_back({"material", "a hole: its box could not be loaded"});
        return out;
    }
    out.push_back(
        {"material", std::string(voxel::material_name(picked.attr.material)) +
                         (picked.attr.is_guessed() ? " (a guess: no colour is known)" : "")});
    const int code = picked.attr.source_class;
    const bool standard = static_cast<std::size_t>(code) < kStandardClasses.size();
    out.push_back(
        {"source class",
         text("%d", code) +
             (standard ? " (ASPRS: " +
                             std::string(kStandardClasses[static_cast<std::size_t>(code)]) + ")"
                       : "")});
    const tiles::SquareGrid squares(world);
    out.push_back({"square", squares.name_of(squares.index_of(p.x, p.z))});
    const voxel::Rgb8 c = picked.attr.colour;
    const std::string colour = text("#%02x%02x%02x", c.r, c.g, c.b);
    out.push_back({"true colour", picked.attr.has_colour()  ? colour
                                  : picked.attr.is_tinted() ? "none; drawn " + colour
                                                            : "none"});
    return out;
}

Picker::Picker(blocks::BlockManager& blocks)
    : m_blocks(blocks), m_thread(thread::start_thread("what is pointed at", [this] { run(); })) {}

Picker::~Picker() {
    {
        const std::lock_guard lock(m_mutex);
        m_stop = true;
    }
    m_wake.notify_all();
    m_thread.join();
}

void Picker::ask(Use use, std::shared_ptr<const shade::View> view, const core::Ray& ray) {
    {
        const std::lock_guard lock(m_mutex);
        m_question = Question{use, std::move(view), ray};
        m_answer.reset();
    }
    m_wake.notify_all();
}

std::optional<Picker::Answer> Picker::take() {
    const std::lock_guard lock(m_mutex);
    return std::exchange(m_answer, std::nullopt);
}

bool Picker::busy() const {
    const std::lock_guard lock(m_mutex);
    return m_busy || m_question;
}

void Picker::run() {
    std::unique_lock lock(m_mutex);
    while (true) {
        m_wake.wait(lock, [this] { return m_stop || m_question; });
        if (m_stop)
            return;
        const Question question = *std::exchange(m_question, std::nullopt);
        m_busy = true;
        lock.unlock();
        walk::BlockReader reader(m_blocks);
        walk::Walker walker(reader, question.view->cut);
        Answer answer{question.use, {}};
        if (const auto hit = walker.first_hit(question.ray))
            answer.picked =
                Picked{hit->voxel,
                       hit->level,
                       question.ray.origin + question.ray.direction * hit->t,
                       hit->t * core::length(question.ray.direction) * question.view->voxel_m,
                       hit->hole,
                       hit->attr};
        lock.lock();
        m_busy = false;
        if (!m_question)
            m_answer = std::move(answer);
    }
}

core::Ray plumb_line(const voxel::WorldInfo& world, double x, double z) noexcept {
    return {{x, world.bounds.max[1] + 1.0, z}, {0, -1, 0}};
}

}  // namespace terravox::preview
