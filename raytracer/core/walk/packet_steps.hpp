#pragma once

#include <cstdint>

#include "common/voxel/box.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/walk/beam.hpp"
#include "raytracer/core/walk/ray_packet.hpp"

namespace terravox::walk {

/// An aligned block of voxels in voxels of the packet's level; both corners are included.
struct PacketCell {
    double low[3], high[3];
};

/// Where the primary rays of a packet pass through the picture, and where they start.
struct PrimaryLanes {
    scene::Camera::Basis camera;
    /// Position in the picture; all entries are set.
    alignas(64) double px[RayPacket::kLanes], py[RayPacket::kLanes];
    /// Rays start where they cross the plane `axis = plane`, in level-0 voxels, which lies ahead of
    /// the eye.
    int axis = 0;
    double plane = 0;
    double low[3] = {}, high[3] = {};  ///< bounds of the start, level-0 voxels, both included
};

/// Everything except px and py, for rays of a beam that start at a plane.
/// @param start of kind BeamStart::Kind::kPlane
[[nodiscard]] PrimaryLanes primary_lanes(const scene::Camera& camera, const BeamStart& start,
                                         const LevelCut& cut) noexcept;

/// The steps of a packet as vector instructions. Sets of lanes are bit masks.
struct PacketSteps {
    /// Fills a packet with primary rays.
    /// @return the lanes that may be walked; the others are unused or start elsewhere
    std::uint32_t (*primary)(RayPacket& packet, const PrimaryLanes& lanes) noexcept;
    /// The lanes of `active` that are in the cell.
    std::uint32_t (*inside)(const RayPacket& packet, const PacketCell& cell,
                            std::uint32_t active) noexcept;
    /// Moves lanes that are in the cell out of it in one leap, as RayState::leap does.
    void (*leap)(RayPacket& packet, const PacketCell& cell, std::uint32_t lanes) noexcept;
    /// Moves those of `lanes` that are in a box to the first solid voxel, out of the box, or to
    /// where nothing is in their way.
    /// @param cells of the box
    /// @param block its voxels
    /// @param steps is incremented
    /// @return the lanes that were stopped, with `brick` set
    std::uint32_t (*box)(RayPacket& packet, const voxel::TreeCell* cells, const PacketCell& block,
                         std::uint32_t lanes, std::uint64_t& steps) noexcept;
    /// Moves the lanes that are going in their boxes, until a quarter of them has been stopped or
    /// has left its box.
    /// @param steps is incremented
    void (*advance)(RayLanes& lanes, std::uint64_t& steps) noexcept;
};

/// The steps for this machine's instructions: AVX-512 or AVX2. nullptr if it has neither; single
/// rays are as fast then. The environment variable TERRAVOX_SIMD (none, avx2) selects less than the
/// machine supports.
[[nodiscard]] const PacketSteps* packet_steps() noexcept;

}  // namespace terravox::walk
