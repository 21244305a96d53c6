#include "tests/bench/entries/embree_scene.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/util/error.hpp"

namespace terravox::bench {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kOffFace = 0.01F;  // voxels that a shadow ray starts before its face: single precision would hit it again

struct Mesh {
    std::vector<float> vertices;
    std::vector<unsigned> quads;

    /// A rectangle on the plane `axis = at`, from (a0, b0) to (a1, b1) on the two other axes in order.
    void add(int axis, int at, int a0, int b0, int a1, int b1) {
        const int corners[4][2] = {{a0, b0}, {a1, b0}, {a1, b1}, {a0, b1}};
        const int a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
        for (const auto& corner : corners) {
            float v[3] = {};
            v[axis] = static_cast<float>(at), v[a] = static_cast<float>(corner[0]), v[b] = static_cast<float>(corner[1]);
            quads.push_back(static_cast<unsigned>(vertices.size() / 3));
            vertices.insert(vertices.end(), v, v + 3);
        }
    }
};

/// Faces of one direction in the row (x, y, *): along z they join to runs, across z each stands alone.
void add_row(Mesh& mesh, const NeutralScene& scene, int x, int y, Face face) {
    const int axis = axis_of(face), step = sign_of(face), far = step > 0 ? 1 : 0;
    const auto exposed = [&](int z) {
        const int dx = axis == 0 ? step : 0, dy = axis == 1 ? step : 0, dz = axis == 2 ? step : 0;
        return scene.at(x, y, z) != 0 && scene.at(x + dx, y + dy, z + dz) == 0;
    };
    for (int z = 0; z < NeutralScene::kSide; ++z) {
        if (!exposed(z)) continue;
        const int first = z;
        if (axis == 2) {
            mesh.add(2, z + far, x, y, x + 1, y + 1);
            continue;
        }
        while (z + 1 < NeutralScene::kSide && exposed(z + 1)) ++z;
        if (axis == 0) mesh.add(0, x + far, y, first, y + 1, z + 1);
        else mesh.add(1, y + far, x, first, x + 1, z + 1);
    }
}

Mesh mesh_of(const NeutralScene& scene) {
    Mesh mesh;
    for (int x = 0; x < NeutralScene::kSide; ++x)
        for (int y = 0; y < NeutralScene::kHeight; ++y)
            for (const Face face : {Face::kWest, Face::kEast, Face::kBottom, Face::kTop, Face::kNorth, Face::kSouth})
                add_row(mesh, scene, x, y, face);
    return mesh;
}

RTCRay ray_of(Vec3 origin, Vec3 direction) noexcept {
    RTCRay ray{};
    ray.org_x = static_cast<float>(origin.x), ray.org_y = static_cast<float>(origin.y), ray.org_z = static_cast<float>(origin.z);
    ray.dir_x = static_cast<float>(direction.x), ray.dir_y = static_cast<float>(direction.y), ray.dir_z = static_cast<float>(direction.z);
    ray.tfar = kInfinity;
    ray.mask = ~0U;
    return ray;
}

}  // namespace

struct EmbreeScene::Impl {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::size_t quads = 0;
    ~Impl() {
        if (scene != nullptr) rtcReleaseScene(scene);
        if (device != nullptr) rtcReleaseDevice(device);
    }
};

EmbreeScene::EmbreeScene(const NeutralScene& scene) : m_impl(std::make_unique<Impl>()) {
    const Mesh mesh = mesh_of(scene);
    m_impl->quads = mesh.quads.size() / 4;
    m_impl->device = rtcNewDevice(nullptr);
    if (m_impl->device == nullptr) throw Error("start Embree: error " + std::to_string(rtcGetDeviceError(nullptr)));
    m_impl->scene = rtcNewScene(m_impl->device);
    RTCGeometry geometry = rtcNewGeometry(m_impl->device, RTC_GEOMETRY_TYPE_QUAD);
    void* vertices =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size() / 3);
    void* quads = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 4 * sizeof(unsigned), m_impl->quads);
    if (vertices == nullptr || quads == nullptr)
        throw Error("build the mesh in Embree: error " + std::to_string(rtcGetDeviceError(m_impl->device)));
    std::copy(mesh.vertices.begin(), mesh.vertices.end(), static_cast<float*>(vertices));
    std::copy(mesh.quads.begin(), mesh.quads.end(), static_cast<unsigned*>(quads));
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(m_impl->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(m_impl->scene);
}

EmbreeScene::~EmbreeScene() = default;

std::size_t EmbreeScene::quads() const noexcept { return m_impl->quads; }

ViewTimes EmbreeScene::trace_view(const Camera& camera) {
    constexpr int kW = NeutralScene::kWidthPx, kH = NeutralScene::kHeightPx;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    std::vector<float> depths(std::size_t{kW} * kH, kInfinity);
    ViewTimes out;
    out.primary_s = seconds_of([&] {
        for (int y = 0; y < kH; ++y)
            for (int x = 0; x < kW; ++x) {
                const Ray ray = camera.ray(x + 0.5, y + 0.5);
                RTCRayHit hit{};
                hit.ray = ray_of(ray.origin, ray.direction);
                hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                rtcIntersect1(m_impl->scene, &context, &hit);
                if (hit.hit.geomID != RTC_INVALID_GEOMETRY_ID) depths[static_cast<std::size_t>(y * kW + x)] = hit.ray.tfar;
            }
    });
    const Vec3 sun = neutral_sun();
    out.shadow_s = seconds_of([&] {
        for (int y = 0; y < kH; ++y)
            for (int x = 0; x < kW; ++x) {
                const float depth = depths[static_cast<std::size_t>(y * kW + x)];
                if (depth == kInfinity) continue;
                ++out.hits;
                const Ray view = camera.ray(x + 0.5, y + 0.5);
                RTCRay ray = ray_of(view.origin + view.direction * static_cast<double>(depth - kOffFace), sun);
                rtcOccluded1(m_impl->scene, &context, &ray);
                if (ray.tfar < 0) ++out.shadowed;
            }
    });
    return out;
}

}  // namespace terravox::bench
