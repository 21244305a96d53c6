#include "raytracer/apps/preview/live_picture.hpp"

#include <cmath>
#include <iterator>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/log.hpp"

namespace terravox::preview {

bool HoleWatch::look(const std::set<voxel::BoxKey>& holes,
                     std::optional<Clock::time_point> idle_since, Clock::time_point now) {
    if (m_requested) {
        if (!m_loaded)
            return false;
        const blocks::BlockPin pin = m_blocks.find(*std::exchange(m_requested, std::nullopt));
        const bool there = pin && !pin->hole;
        m_since = now;
        m_wait = there ? kFirst : std::min(m_wait * 2, kMax);
        return there;
    }
    if (!idle_since)
        return false;
    if (holes.empty())
        m_wait = kFirst;
    if (holes.empty() || now - std::max(m_since, *idle_since) < m_wait)
        return false;
    // A different hole each time: some may be damaged permanently.
    m_requested = *std::next(holes.begin(), static_cast<std::ptrdiff_t>(m_turn++ % holes.size()));
    m_loaded = false;
    m_blocks.forget_holes();
    m_blocks.wait_for(*m_requested, *this, 0);
    return false;
}

RowRange ScreenDeveloper::update(Progressive& picture, const scene::Scene::Output& output,
                                 Layer layer) {
    // After a scene that cannot be rendered, the film is that of the previous picture.
    const output::Film* const film = picture.film();
    if (film == nullptr || film->width_px() != m_screen.width_px ||
        film->height_px() != m_screen.height_px)
        return {};
    auto changes = picture.take_changes();
    m_develops_all |= m_output.exposure_ev != output.exposure_ev || m_output.tone != output.tone;
    m_output = output;
    if (m_develops_all && picture.whole()) {
        tiles::RenderTile all;
        all.x1 = m_screen.width_px;
        all.y1 = m_screen.height_px;
        changes = {all};
        m_develops_all = false;
    }
    RowRange rows{m_screen.height_px, 0};
    for (const tiles::RenderTile& tile : changes) {
        show(*film, *picture.view(), output, layer, tile, m_screen);
        rows.first = std::min(rows.first, tile.y0);
        rows.end = std::max(rows.end, std::min(tile.y1 + tile.step, m_screen.height_px));
    }
    return rows;
}

namespace {

// A first pass may continue for this long after the scene has changed: else nothing would be shown
// while the camera moves.
constexpr std::chrono::milliseconds kMaxOutdated{50};
constexpr double kMaxFirst_s = 0.03, kMinFirst_s = 0.008;  // range of the time for a first pass
constexpr int kCoarsest = 64;
constexpr int kFinest = 4;

/// The fields that do not affect a picture's light.
void leave_out_developing(scene::Scene& scene) {
    const scene::Scene::Output usual;
    scene.output.exposure_ev = usual.exposure_ev;
    scene.output.tone = usual.tone;
    scene.output.tiff = usual.tiff;
    scene.output.credit = usual.credit;
    scene.output.denoise = usual.denoise;
}

/// Whether a picture of one scene is also a picture of the other. A film may have more layers than
/// requested.
bool shows(const scene::Scene& shown, const scene::Scene& wanted) {
    if (wanted == shown)
        return true;
    scene::Scene with_layers = wanted;
    with_layers.output.layers = core::PictureLayers::kAll;
    return with_layers == shown;
}

}  // namespace

scene::Scene scene_to_show(Layer layer, const scene::Scene& scene, double resolution,
                           const Pane& pane) {
    scene::Scene out = scene_for(layer, scene);
    const auto scaled = [resolution](int px) {
        return std::max(static_cast<int>(std::lround(px * resolution)), 1);
    };
    out.output.size_px = {scaled(pane.width), scaled(pane.height)};
    leave_out_developing(out);
    return out;
}

namespace {

/// The edge of the first pass's pixels for the next picture, a power of two, chosen so that a first
/// pass takes between 8 and 30 ms.
/// @param first_s time that the last first pass took
int next_first_step(int first_step, double first_s) noexcept {
    if (first_s > kMaxFirst_s)
        return std::min(first_step * 2, kCoarsest);
    if (first_s < kMinFirst_s)
        return std::max(first_step / 2, kFinest);
    return first_step;
}

}  // namespace

LivePicture::LivePicture(const render::RenderPoolOptions& render_pool, blocks::BlockManager& blocks,
                         const farm::BoxSource& source, FrameTimes& times)
    : m_blocks(blocks),
      m_times(times),
      m_render_pool(render_pool, blocks, source),
      m_picture(blocks, [this](const shade::View& view) { return begin(view); }),
      m_holes(blocks) {}

std::shared_ptr<processors::TileProcessor> LivePicture::begin(const shade::View& view) {
    if (!is_probe(m_layer))
        return m_render_pool.begin(view);
    m_probe = std::make_shared<ProbeProcessor>(view, m_blocks, m_layer);
    return m_probe;
}

bool LivePicture::has_missing_box_arrived(bool may_retry, Clock::time_point now) {
    if (m_picture.busy())
        m_idle_since = now;
    const bool idle = may_retry && !m_picture.busy();
    const bool came =
        m_holes.look(m_picture.holes(), idle ? std::optional(m_idle_since) : std::nullopt, now);
    if (came)
        util::log_debug("a box that was a hole has come");
    return came;
}

void LivePicture::note_change(Clock::time_point changed_at) {
    if (!m_changed_at)
        m_changed_at = changed_at;
}

void LivePicture::update(const scene::Scene& wanted, Layer layer, bool restart,
                         Clock::time_point changed_at, Clock::time_point now) {
    if (m_shown && same_film(m_layer, layer) && shows(*m_shown, wanted) && !restart)
        return update_layer(wanted, layer, now);
    note_change(changed_at);
    // The first picture will be that of the newest change; it also ends the wait for older ones.
    if (m_picture.busy() && !m_picture.whole() && now - m_started_at < kMaxOutdated)
        return;
    m_layer = layer;
    m_probe_retry.reset();
    start(wanted, m_first_step, now);
}

// The film is unchanged. Boxes that probes did not find may be in memory now; new pixels replace
// the old ones tile by tile.
void LivePicture::update_layer(const scene::Scene& wanted, Layer layer, Clock::time_point now) {
    if (m_layer != layer)
        m_developer.develop_again();
    m_layer = layer;
    if (!is_probe(layer) || m_picture.busy() || missing() == 0 || !m_probe_retry.is_due(now))
        return;
    m_probe_retry.note(missing());
    start(wanted, 1, now);
}

void LivePicture::start(const scene::Scene& wanted, int first_step, Clock::time_point now) {
    m_shown = wanted;
    m_started_at = now;
    m_idle_since = now;
    m_probe_retry.begin(now);
    m_developer.begin_picture();
    m_probe.reset();
    try {
        m_picture.start(wanted, first_step);
    } catch (const util::Error&) {
        m_changed_at.reset();
        m_times.stop(m_picture.last_stop_s());
        throw;
    }
    m_times.stop(m_picture.last_stop_s());
    m_developer.resize(wanted.output.size_px[0], wanted.output.size_px[1]);
    ++m_started_count;
}

void LivePicture::note_shown(Clock::time_point now) {
    if (!m_changed_at || !m_picture.whole() || m_started_at < *m_changed_at)
        return;
    const double after_s = seconds(now - *m_changed_at);
    m_times.first_picture(after_s);
    util::log_debug("first picture after {:.1f} ms, step {}", after_s * 1e3, m_first_step);
    m_changed_at.reset();
    m_first_step = next_first_step(m_first_step, m_picture.status().first_s);
}

}  // namespace terravox::preview
