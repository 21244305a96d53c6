#pragma once

#include <memory>
#include <span>
#include <string>

#include "common/voxel/box_builder.hpp"
#include "common/voxel/world.hpp"
#include "tests/voxelserver/make/worlds/remote/bad_server.hpp"

namespace terravox::test {

/// A box that is another one for each key.
inline std::shared_ptr<const voxel::Box> to_box(const voxel::BoxKey& key) {
    voxel::BoxBuilder builder;
    for (int x = 0; x < voxel::kBoxSizeX; ++x)
        for (int z = 0; z < voxel::kBoxSizeZ; ++z)
            builder.add(x, z, 0, 5 + (x * 3 + z * 7) % 40, true);
    return builder.build(key, [](int x, int, int z) {
        voxel::VoxelAttr attr;
        attr.source_class = static_cast<std::uint8_t>(x ^ z);
        return attr;
    });
}

inline std::string to_bytes(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline Deed problem(int status, const std::string& headers = "") {
    return {.status = status,
            .type = "application/problem+json",
            .body = R"({"detail": "not\ntoday"})",
            .headers = headers};
}

inline Deed good_world() {
    voxel::WorldInfo info;
    info.title = "a bad world";
    info.bounds = {{0, -256, 0}, {640, 256, 640}};
    return {.body = voxel::world_to_json(info)};
}

/// The description of a world is always good; boxes are what `boxes` says.
inline BadServer::Script world_with(BadServer::Script boxes) {
    return [boxes = std::move(boxes)](const std::string& path, int n) {
        return path == "/v2/world" ? good_world() : boxes(path, n);
    };
}

}  // namespace terravox::test
