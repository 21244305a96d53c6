#include "tests/bench/entries/embree_scene.hpp"

#if TERRAVOX_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "common/util/error.hpp"
#include "tests/bench/entries/embree_mesh.hpp"

namespace terravox::bench {
namespace {

constexpr int kW = NeutralScene::kWidthPx;
constexpr int kH = NeutralScene::kHeightPx;
constexpr int kPacket = 16, kPacketPx = 4;  // rays of a packet; edge of its pixels
static_assert(kPacketPx * kPacketPx == kPacket && kTracedTilePx % kPacketPx == 0);
constexpr float kInfinity = std::numeric_limits<float>::infinity();
// Voxels that a shadow ray starts before its face. A place 1000 voxels away is known to 0.0002 or
// so in single precision: nearer, the ray would hit its own face; farther, it would look past the
// edges that shade it.
constexpr float kOffFace = 0.002F;

struct Vec3f {
    float x = 0;
    float y = 0;
    float z = 0;
    Vec3f() = default;
    explicit Vec3f(core::Vec3 v) noexcept
        : x(static_cast<float>(v.x)), y(static_cast<float>(v.y)), z(static_cast<float>(v.z)) {}
};

/// Camera in single precision, as Embree's rays are: making rays should cost it as little as it
/// can.
struct FloatCamera {
    explicit FloatCamera(const NeutralView& view) noexcept : origin(view.position) {
        const core::Vec3 ahead = core::normalized(view.target - view.position);
        const core::Vec3 aside = core::normalized(core::cross(ahead, {0, 1, 0}));
        const double half = std::tan(view.fov_deg * std::numbers::pi / 360);
        forward = Vec3f(ahead);
        right = Vec3f(aside * (half * kW / kH));
        up = Vec3f(core::cross(aside, ahead) * half);
    }
    /// Unit vector through the centre of a pixel.
    void direction(int px, int py, float& x, float& y, float& z) const noexcept {
        const float a = 2 * (static_cast<float>(px) + 0.5F) / kW - 1;
        const float b = 1 - 2 * (static_cast<float>(py) + 0.5F) / kH;
        x = forward.x + right.x * a + up.x * b;
        y = forward.y + right.y * a + up.y * b;
        z = forward.z + right.z * a + up.z * b;
        const float scale = 1 / std::sqrt(x * x + y * y + z * z);
        x *= scale;
        y *= scale;
        z *= scale;
    }
    Vec3f origin;
    Vec3f forward;
    Vec3f right;
    Vec3f up;
};

extern "C" bool add_to_memory(void* total_bytes, ssize_t bytes, bool) noexcept {
    *static_cast<std::atomic<std::int64_t>*>(total_bytes) += bytes;
    return true;
}

// Embree 4 renamed what a call is told besides its rays, and made it the last argument.
#if TERRAVOX_EMBREE >= 4
RTCIntersectArguments coherent_rays() noexcept {
    RTCIntersectArguments out;
    rtcInitIntersectArguments(&out);
    out.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    return out;
}

RTCOccludedArguments coherent_shadows() noexcept {
    RTCOccludedArguments out;
    rtcInitOccludedArguments(&out);
    out.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    return out;
}

void intersect(const int* valid, RTCScene scene, RTCIntersectArguments& how, RTCRayHit16& rays) {
    rtcIntersect16(valid, scene, &rays, &how);
}

void occlude(RTCScene scene, RTCOccludedArguments& how, RTCRay& ray) {
    rtcOccluded1(scene, &ray, &how);
}
#else
RTCIntersectContext coherent_rays() noexcept {
    RTCIntersectContext out;
    rtcInitIntersectContext(&out);
    out.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    return out;
}

RTCIntersectContext coherent_shadows() noexcept {
    return coherent_rays();
}

void intersect(const int* valid, RTCScene scene, RTCIntersectContext& how, RTCRayHit16& rays) {
    rtcIntersect16(valid, scene, &how, &rays);
}

void occlude(RTCScene scene, RTCIntersectContext& how, RTCRay& ray) {
    rtcOccluded1(scene, &how, &ray);
}
#endif

struct Release {
    void operator()(RTCDevice device) const noexcept { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const noexcept { rtcReleaseScene(scene); }
    void operator()(RTCGeometry geometry) const noexcept { rtcReleaseGeometry(geometry); }
};

class Embree final : public EmbreeScene {
public:
    Embree(const NeutralScene& scene, int threads);
    [[nodiscard]] const Building& building() const noexcept override { return m_building; }
    void begin(const NeutralView& view) override;
    void trace_primary(int x0, int y0, int thread) override;
    void trace_shadow(int x0, int y0, int thread) override;
    [[nodiscard]] std::size_t hits() const override {
        return static_cast<std::size_t>(
            std::count_if(m_depths.begin(), m_depths.end(), [](float t) { return t < kInfinity; }));
    }
    [[nodiscard]] std::size_t shadowed() const override {
        return static_cast<std::size_t>(std::count(m_shadowed.begin(), m_shadowed.end(), 1));
    }

private:
    void fill_buffers(RTCGeometry geometry, const std::vector<QuadMesh>& slabs);
    std::atomic<std::int64_t> m_bytes{
        0};  ///< that Embree holds; its device writes to it until the end
    std::unique_ptr<RTCDeviceTy, Release> m_device;
    std::unique_ptr<RTCSceneTy, Release> m_scene;
    Building m_building;
    FloatCamera m_camera{neutral_views().front()};
    std::vector<float> m_depths;  ///< row by row, infinite where nothing was hit
    std::vector<char> m_shadowed;
};

Embree::Embree(const NeutralScene& scene, int threads)
    : m_device(rtcNewDevice(("threads=" + std::to_string(threads)).c_str())) {
    if (!m_device)
        throw util::Error("start Embree: error " + std::to_string(rtcGetDeviceError(nullptr)));
    rtcSetDeviceMemoryMonitorFunction(m_device.get(), add_to_memory, &m_bytes);
    m_scene.reset(rtcNewScene(m_device.get()));
    const std::unique_ptr<RTCGeometryTy, Release> geometry(
        rtcNewGeometry(m_device.get(), RTC_GEOMETRY_TYPE_QUAD));
    m_building.mesh_s =
        measure_seconds([&] { fill_buffers(geometry.get(), mesh_slabs(scene, threads)); });
    m_building.mesh_bytes = static_cast<std::size_t>(m_bytes);
    m_building.bvh_s = measure_seconds([&] {
        rtcCommitGeometry(geometry.get());
        rtcAttachGeometry(m_scene.get(), geometry.get());
        rtcCommitScene(m_scene.get());
    });
    const RTCError error = rtcGetDeviceError(m_device.get());
    if (error != RTC_ERROR_NONE)
        throw util::Error("build in Embree: error " + std::to_string(error));
    m_building.bvh_bytes = static_cast<std::size_t>(m_bytes) - m_building.mesh_bytes;
}

void Embree::fill_buffers(RTCGeometry geometry, const std::vector<QuadMesh>& slabs) {
    m_building.quads =
        std::accumulate(slabs.begin(), slabs.end(), std::size_t{0},
                        [](std::size_t n, const QuadMesh& s) { return n + s.quads(); });
    const std::size_t corners = 4 * m_building.quads;
    auto* to = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), corners));
    auto* quads = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4,
                                4 * sizeof(unsigned), m_building.quads));
    if (to == nullptr || quads == nullptr)
        throw util::Error("put the mesh into Embree: error " +
                          std::to_string(rtcGetDeviceError(m_device.get())));
    for (const QuadMesh& slab : slabs)
        to = std::copy(slab.corners.begin(), slab.corners.end(), to);
    std::iota(quads, quads + corners, 0U);
}

void Embree::begin(const NeutralView& view) {
    m_camera = FloatCamera(view);
    m_depths.assign(NeutralScene::pixel_index(0, kH), kInfinity);
    m_shadowed.assign(NeutralScene::pixel_index(0, kH), 0);
}

void Embree::trace_primary(int x0, int y0, int) {
    auto how = coherent_rays();
    alignas(64) int valid[kPacket];
    std::fill(valid, valid + kPacket, -1);
    for (int y = y0; y < y0 + kTracedTilePx; y += kPacketPx)
        for (int x = x0; x < x0 + kTracedTilePx; x += kPacketPx) {
            RTCRayHit16 rays{};
            for (int i = 0; i < kPacket; ++i) {
                m_camera.direction(x + i % kPacketPx, y + i / kPacketPx, rays.ray.dir_x[i],
                                   rays.ray.dir_y[i], rays.ray.dir_z[i]);
                rays.ray.org_x[i] = m_camera.origin.x;
                rays.ray.org_y[i] = m_camera.origin.y;
                rays.ray.org_z[i] = m_camera.origin.z;
                rays.ray.tfar[i] = kInfinity;
                rays.ray.mask[i] = ~0U;
                rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            }
            intersect(valid, m_scene.get(), how, rays);
            // What was not hit keeps its end: infinity.
            for (int i = 0; i < kPacket; ++i)
                m_depths[NeutralScene::pixel_index(x + i % kPacketPx, y + i / kPacketPx)] =
                    rays.ray.tfar[i];
        }
}

void Embree::trace_shadow(int x0, int y0, int) {
    auto how = coherent_shadows();
    const Vec3f sun(neutral_sun());
    for (int y = y0; y < y0 + kTracedTilePx; ++y)
        for (int x = x0; x < x0 + kTracedTilePx; ++x) {
            const float depth = m_depths[NeutralScene::pixel_index(x, y)] - kOffFace;
            if (depth == kInfinity)
                continue;
            float dx = 0;
            float dy = 0;
            float dz = 0;
            m_camera.direction(x, y, dx, dy, dz);
            RTCRay ray{};
            ray.org_x = m_camera.origin.x + dx * depth;
            ray.org_y = m_camera.origin.y + dy * depth;
            ray.org_z = m_camera.origin.z + dz * depth;
            ray.dir_x = sun.x;
            ray.dir_y = sun.y;
            ray.dir_z = sun.z;
            ray.tfar = kInfinity;
            ray.mask = ~0U;
            occlude(m_scene.get(), how, ray);
            m_shadowed[NeutralScene::pixel_index(x, y)] = ray.tfar < 0;
        }
}

}  // namespace

std::unique_ptr<EmbreeScene> make_embree_scene(const NeutralScene& scene, int threads) {
    return std::make_unique<Embree>(scene, threads);
}

}  // namespace terravox::bench
