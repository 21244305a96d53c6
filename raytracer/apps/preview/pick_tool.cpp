#include "raytracer/apps/preview/pick_tool.hpp"

#include <imgui.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/geo/crs.hpp"
#include "common/thread/start_threads.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "raytracer/core/tiles/square_grid.hpp"
#include "raytracer/core/walk/walk.hpp"

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

}  // namespace

std::vector<PickedFact> collect_facts(const Picked& picked, const voxel::WorldInfo& world) {
    std::vector<PickedFact> out;
    out.push_back(
        {"voxel", fmt::format("{}, {}, {}", picked.voxel.x, picked.voxel.y, picked.voxel.z) +
                      (picked.level > 0 ? fmt::format(" of level {}", picked.level) : "")});
    const core::Vec3 p = picked.point;
    const double easting = p.x * world.crs_units_per_voxel;
    const double northing = -p.z * world.crs_units_per_voxel;
    const double height_m = p.y * world.voxel_m;
    if (!world.crs.empty()) {
        out.push_back({world.crs, fmt::format("{:.2f}, {:.2f}", easting, northing)});
        try {
            const geo::LatLon at =
                geo::to_lat_lon(geo::Crs::from_wkt(world.crs_wkt), easting, northing);
            out.push_back({"lat, lon", fmt::format("{:.7f}, {:.7f}", at.lat_deg, at.lon_deg)});
        } catch (const util::Error&) {
            out.push_back({"lat, lon", "not defined here"});
        }
    } else {
        out.push_back({"world", fmt::format("{:.2f} m east, {:.2f} m south", p.x * world.voxel_m,
                                            p.z * world.voxel_m)});
    }
    out.push_back({"height", fmt::format("{:.2f} m", height_m)});
    out.push_back({"distance", fmt::format("{:.1f} m", picked.distance_m)});
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
         std::to_string(code) +
             (standard ? " (ASPRS: " +
                             std::string(kStandardClasses[static_cast<std::size_t>(code)]) + ")"
                       : "")});
    const tiles::SquareGrid squares(world);
    out.push_back({"square", squares.to_name(squares.compute_index(p.x, p.z))});
    const voxel::Rgb8 c = picked.attr.colour;
    const std::string colour = fmt::format("#{:02x}{:02x}{:02x}", c.r, c.g, c.b);
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

namespace {

std::string metres(double m) {
    return fmt::format("{:.2f} m", m);
}

void draw_row(const std::string& name, const std::string& value) {
    ImGui::TextDisabled("%s", name.c_str());
    ImGui::SameLine(ImGui::GetFontSize() * 8);
    ImGui::TextWrapped("%s", value.c_str());
}

}  // namespace

Measured measure(const Picked& from, const Picked& to, double voxel_m) noexcept {
    const core::Vec3 way = (to.point - from.point) * voxel_m;
    Measured out;
    out.level_m = std::hypot(way.x, way.z);
    out.height_m = way.y;
    out.length_m = core::length(way);
    out.heading_deg = std::atan2(way.x, -way.z) * 180 / std::numbers::pi;
    if (out.heading_deg < 0)
        out.heading_deg += 360;
    return out;
}

std::optional<core::Ray> ray_through(const scene::Camera& camera, std::array<int, 2> picture_px,
                                     const Pane& pane, double x, double y) noexcept {
    if (!pane.holds(x, y))
        return std::nullopt;
    const double px = (x - pane.x) / pane.width * picture_px[0];
    const double py = (y - pane.y) / pane.height * picture_px[1];
    return camera.ray(px, py, 0.5, 0.5);
}

void PickTool::click(const EditorState& editor_state, const Navigator::Click& click,
                     const Pane& pane, const std::shared_ptr<const shade::View>& view) {
    if (!view)
        return;
    const auto ray = ray_through(view->camera, view->scene.output.size_px, pane, click.x, click.y);
    if (!ray)
        return;
    Picker::Use use = editor_state.measures ? Picker::Use::kMeasure : Picker::Use::kRead;
    if (click.twice)
        use = Picker::Use::kFocus;
    m_picker.ask(use, view, *ray);
}

void PickTool::go(const EditorState& editor_state, double x, double z,
                  const std::shared_ptr<const shade::View>& view) {
    m_go = {x, editor_state.viewpoint.target.y, z};
    m_picker.ask(Picker::Use::kGo, view, plumb_line(editor_state.info(), x, z));
}

bool PickTool::update(EditorState& editor_state) {
    const auto answer = m_picker.take();
    if (!answer)
        return false;
    using Use = Picker::Use;
    const auto& picked = answer->picked;
    switch (answer->use) {
        case Use::kRead:
            m_read = picked;
            if (!picked) {
                editor_state.notify("nothing there: the ray leaves the world");
                return false;
            }
            m_facts = collect_facts(*picked, editor_state.info());
            for (const PickedFact& fact : m_facts)
                util::log_debug("picked {}: {}", fact.name, fact.value);
            return false;
        case Use::kMeasure:
            if (!picked)
                editor_state.notify("nothing there to measure: the ray leaves the world");
            else if (!m_first || m_second) {
                m_first = picked;
                m_second.reset();
            } else
                m_second = picked;
            if (m_second) {
                const Measured m = measure(*m_first, *m_second, editor_state.info().voxel_m);
                util::log_debug("measured {:.2f} m on the map, {:.2f} m up, {:.2f} m in all",
                                m.level_m, m.height_m, m.length_m);
            }
            return false;
        case Use::kFocus:
            if (!picked)
                return false;
            editor_state.viewpoint.face(picked->point);
            break;
        case Use::kGo: editor_state.viewpoint.go_to(picked ? picked->point : m_go); break;
    }
    editor_state.moved();
    return true;
}

void PickTool::draw_marks(const shade::View& view, const Pane& pane) const {
    constexpr ImU32 kDark = IM_COL32(0, 0, 0, 200);
    constexpr ImU32 kReading = IM_COL32(90, 220, 255, 255);
    constexpr ImU32 kMeasuring = IM_COL32(255, 210, 60, 255);
    ImDrawList& above = *ImGui::GetBackgroundDrawList();
    above.PushClipRect(
        {static_cast<float>(pane.x), static_cast<float>(pane.y)},
        {static_cast<float>(pane.x + pane.width), static_cast<float>(pane.y + pane.height)});
    const auto find_place = [&](const std::optional<Picked>& p) -> std::optional<ImVec2> {
        const auto at =
            p ? find_pixel(view.camera, p->point, pane.width, pane.height) : std::nullopt;
        if (!at)
            return std::nullopt;
        return ImVec2{static_cast<float>(pane.x + (*at)[0]), static_cast<float>(pane.y + (*at)[1])};
    };
    const auto from = find_place(m_first);
    const auto to = find_place(m_second);
    if (from && to) {
        above.AddLine(*from, *to, kDark, 4);
        above.AddLine(*from, *to, kMeasuring, 2);
    }
    const auto mark = [&](const std::optional<ImVec2>& at, ImU32 colour) {
        if (at) {
            above.AddCircle(*at, 6, kDark, 0, 4);
            above.AddCircle(*at, 6, colour, 0, 2);
        }
    };
    mark(find_place(m_read), kReading);
    mark(from, kMeasuring);
    mark(to, kMeasuring);
    above.PopClipRect();
}

void PickTool::draw_distance(const voxel::WorldInfo& world) const {
    if (m_first && m_second) {
        const Measured m = measure(*m_first, *m_second, world.voxel_m);
        draw_row("on the map", metres(m.level_m));
        draw_row("height", metres(m.height_m));
        draw_row("in all", metres(m.length_m));
        draw_row("towards", std::to_string(std::lround(m.heading_deg)) + "\u00b0");
    } else if (m_first) {
        ImGui::TextUnformatted("click on the other end");
    }
}

void PickTool::draw_facts(EditorState& editor_state) const {
    const float font = ImGui::GetFontSize();
    std::string all;
    for (const PickedFact& fact : m_facts) {
        draw_row(fact.name, fact.value);
        all += fact.name + ": " + fact.value + "\n";
    }
    if (m_read->attr.has_colour() && !m_read->hole) {
        const voxel::Rgb8 c = m_read->attr.colour;
        ImGui::SameLine();
        ImGui::ColorButton("##colour", {c.r / 255.0f, c.g / 255.0f, c.b / 255.0f, 1},
                           ImGuiColorEditFlags_NoTooltip, {font, font});
    }
    if (ImGui::Button("Copy"))
        ImGui::SetClipboardText(all.c_str());
    ImGui::SameLine();
    if (ImGui::Button("Look at it")) {
        editor_state.viewpoint.face(m_read->point);
        editor_state.moved();
    }
    ImGui::SameLine();
    if (ImGui::Button("Focus lens"))
        editor_state.scene.camera.focus_m = std::clamp(m_read->distance_m, 0.001, 1e7);
}

void PickTool::draw(EditorState& editor_state, const shade::View& view, const Pane& pane,
                    std::array<int, 2> window_px) {
    draw_marks(view, pane);
    if (!m_read && !m_first && !m_picker.busy())
        return;
    const float font = ImGui::GetFontSize();
    ImGui::SetNextWindowPos({static_cast<float>(window_px[0]) - font, font * 3}, ImGuiCond_Always,
                            {1, 0});
    ImGui::SetNextWindowSize({font * 26, 0});
    bool open = true;
    ImGui::Begin(editor_state.measures ? "Distance" : "Voxel", &open,
                 ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav |
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize);
    if (m_picker.busy())
        ImGui::TextDisabled("looking it up ...");
    if (editor_state.measures)
        draw_distance(editor_state.info());
    else if (m_read)
        draw_facts(editor_state);
    ImGui::End();
    if (!open)
        clear();
}

}  // namespace terravox::preview
