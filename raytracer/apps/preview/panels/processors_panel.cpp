#include "raytracer/apps/preview/panels/panels.hpp"

#include <imgui.h>

#include <algorithm>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "raytracer/apps/preview/panels/form.hpp"

namespace terravox::panels {
namespace {

constexpr std::chrono::milliseconds kAskAgain{250};
constexpr double kSmooth_s = 1;

}  // namespace

void ProcessorsPanel::note_speeds(double passed_s) {
    std::map<processors::ProcessorPool::MemberId, Speed> speeds;
    for (const render::RenderPool::Participant& h : m_participants) {
        // Another picture has other members, which count from 0 and may have the numbers of the
        // last.
        const Speed before = m_speeds[h.status.id];
        const std::uint64_t more =
            h.status.bands - (h.status.bands < before.tiles ? 0 : before.tiles);
        const double share = std::min(passed_s / kSmooth_s, 1.0);
        speeds[h.status.id] = {h.status.bands,
                               before.tiles_per_s + share * (static_cast<double>(more) / passed_s -
                                                             before.tiles_per_s)};
    }
    m_speeds = std::move(speeds);
}

void ProcessorsPanel::update(const render::RenderPool& render_pool) {
    const auto now = std::chrono::steady_clock::now();
    if (now - m_updated <= kAskAgain)
        return;
    const double passed_s = std::chrono::duration<double>(now - m_updated).count();
    m_participants = render_pool.participants();
    m_dialled = render_pool.dialled();
    m_updated = now;
    note_speeds(passed_s);
}

void ProcessorsPanel::draw(preview::EditorState& editor_state, render::RenderPool& render_pool) {
    update(render_pool);
    draw_local(render_pool);
    draw_workers(editor_state, render_pool);
    draw_participants();
}

/// Draws the green processor and the threads of this process.
void ProcessorsPanel::draw_local(render::RenderPool& render_pool) const {
    const bool alone = render_pool.threads() == 0 && m_dialled.empty();
    bool green = render_pool.green();
    ImGui::BeginDisabled(green && alone);
    if (ImGui::Checkbox("green: on the window's own thread", &green))
        render_pool.set_green(green);
    widgets::report_place("green");
    ImGui::EndDisabled();
    widgets::tip("rays between two frames, for a slice of time");
    int threads = render_pool.threads();
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * 0.5f);
    if (ImGui::SliderInt("threads", &threads, 0, 2 * thread::thread_count(0))) {
        render_pool.set_threads(std::clamp(threads, 0, 1024));
        if (threads == 0 && m_dialled.empty())
            render_pool.set_green(true);  // at least one processor is needed
    }
    widgets::report_place("threads");
}

/// Draws the workers that are dialled, and a field for another one.
void ProcessorsPanel::draw_workers(preview::EditorState& editor_state,
                                   render::RenderPool& render_pool) {
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * 0.5f);
    if (const auto typed = widgets::text_input("##address", m_address, 200, "host:port"))
        m_address = typed->text;
    widgets::report_place("address");
    ImGui::SameLine();
    if (widgets::button("Add worker", !m_address.empty())) {
        editor_state.attempt([&] {
            render_pool.dial(sockets::Address::parse(m_address, net::kWorkerPort));
            m_address.clear();
        });
    }
    for (const std::string& address : m_dialled) {
        ImGui::PushID(address.c_str());
        if (ImGui::SmallButton("x")) {
            render_pool.hang_up(address);
            if (render_pool.threads() == 0 && m_dialled.size() == 1)
                render_pool.set_green(true);
        }
        widgets::tip("send it away");
        ImGui::SameLine();
        ImGui::TextUnformatted(address.c_str());
        ImGui::PopID();
    }
}

void ProcessorsPanel::draw_participants() {
    constexpr ImGuiTableFlags kTable =
        ImGuiTableFlags_RowBg | ImGuiTableFlags_BordersInnerV | ImGuiTableFlags_SizingStretchProp;
    if (m_participants.empty() || !ImGui::BeginTable("hands", 6, kTable))
        return;
    for (const char* heading : {"name", "state", "tiles/s", "kpx/s", "ms", "MiB"})
        ImGui::TableSetupColumn(heading);
    ImGui::TableHeadersRow();
    for (const render::RenderPool::Participant& h : m_participants) {
        const auto cell = [](const char* format, auto value) {
            ImGui::TableNextColumn();
            ImGui::Text(format, value);
        };
        const bool far = h.status.kind == std::string_view("socket");
        cell("%s", far ? h.status.name.c_str() : h.status.kind);
        widgets::tip(h.status.name + (h.peer.empty() ? "" : " at " + h.peer) + ", " +
                     std::to_string(h.status.threads) + " threads, " +
                     std::to_string(h.status.bands) + " tiles of this picture, busy " +
                     std::to_string(static_cast<int>(100 * h.status.busy_share)) + " %");
        cell("%s", h.status.state);
        cell("%.1f", m_speeds[h.status.id].tiles_per_s);
        cell("%.0f", h.status.pixels_per_s / 1e3);
        cell("%.1f", h.status.latency_s * 1e3);
        cell("%llu", static_cast<unsigned long long>(h.memory_bytes >> 20));
    }
    ImGui::EndTable();
}

}  // namespace terravox::panels
