#pragma once

#include <cstdint>

#include "common/voxel/box.hpp"
#include "raytracer/scene/camera.hpp"
#include "raytracer/walk/beam.hpp"
#include "raytracer/walk/ray_lanes.hpp"
#include "raytracer/walk/ray_packet.hpp"

namespace terravox::walk {

/// An aligned block of voxels, both corners included, in voxels of the packet's level.
struct PacketCell {
    double low[3], high[3];
};

/// Where the primary rays of a packet go through the picture, and where they start.
struct PrimaryLanes {
    scene::Camera::Basis camera;
    alignas(64) double px[RayPacket::kLanes], py[RayPacket::kLanes];  ///< all are set
    int axis = 0;                      ///< they start where they cross this plane,
    double plane = 0;                  ///< which lies ahead of the eye,
    double low[3] = {}, high[3] = {};  ///< in voxels of level 0 within these bounds, both included
};

/// All but the points, for rays of a beam that start at a plane. @param start
/// BeamStart::Kind::kPlane
[[nodiscard]] PrimaryLanes primary_lanes(const scene::Camera& camera, const BeamStart& start,
                                         const LevelCut& cut) noexcept;

/// The steps of a packet in vector instructions. Lanes are bits of a mask.
struct PacketSteps {
    /// Fills a packet with primary rays. @return the lanes that may be walked; the others are no
    /// lanes, or start elsewhere
    std::uint32_t (*primary)(RayPacket& packet, const PrimaryLanes& lanes) noexcept;
    /// Those of `active` that are in the cell.
    std::uint32_t (*inside)(const RayPacket& packet, const PacketCell& cell,
                            std::uint32_t active) noexcept;
    /// Takes lanes that are in the cell out of it, in one leap: RayState::leap.
    void (*leap)(RayPacket& packet, const PacketCell& cell, std::uint32_t lanes) noexcept;
    /// Takes lanes of `lanes` that are in a box to the first solid voxel each, or out of it, or to
    /// where nothing is in their way.
    /// @param cells of the box @param block its voxels @param steps counted up @return those that
    /// were stopped, with `brick` set
    std::uint32_t (*box)(RayPacket& packet, const voxel::TreeCell* cells, const PacketCell& block,
                         std::uint32_t lanes, std::uint64_t& steps) noexcept;
    /// Takes lanes that are going on in their boxes, until a quarter of them has been stopped or
    /// has left its box. @param steps counted up
    void (*advance)(RayLanes& lanes, std::uint64_t& steps) noexcept;
};

/// Those for this machine's instructions: AVX-512 or AVX2. nullptr: it has neither, and single rays
/// are as fast. TERRAVOX_SIMD=none or avx2 in the environment chooses less than there is.
[[nodiscard]] const PacketSteps* packet_steps() noexcept;

}  // namespace terravox::walk
