#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"

namespace terravox::worlds {

/// How the workers of a farm get the boxes of a world.
enum class FarmAccess : std::uint8_t {
    kFromCoordinator,  ///< the coordinator sends them
    kByAddress,        ///< a worker may use the same address, where its configuration allows that
    kBySeed,           ///< a worker makes them itself from the input's text
};

/// The arguments for opening a world. The opened world outlives the references, except `times`.
struct OpenRequest {
    const WorldOptions& options;
    util::StageTimes& times;      ///< receives the time of every step; outlives the world
    const std::stop_token& stop;  ///< of a remote world: ends opening and every later request

    /// The first input; the only one of kinds that take one.
    [[nodiscard]] const std::string& input() const { return options.inputs.front(); }
};

/// The arguments for describing an input (`world info`).
struct DescribeRequest {
    const std::string& input;
    const std::string& dimension;  ///< of a Minecraft world: only this one; empty: all
    bool with_blocks = false;      ///< count the blocks of each name, too
    bool as_json = false;
    int threads = 0;  ///< 0 = one for each core
};
struct Description {
    std::string text;  ///< one fact a line, or JSON; without a final line feed
    bool is_damaged = false;
};

/// A kind of world: how it is recognised and opened. A new kind is a folder below
/// voxelserver/make/worlds that defines one of these, and a row of world_kinds()
/// (voxelserver/make/worlds/open/world_kinds.cpp).
struct WorldKind {
    std::string_view noun;  ///< with its article, for messages: "a Minecraft world"
    /// Description of the input for help: "a Minecraft world (folder or ZIP)". Empty where that of
    /// another kind covers it.
    std::string_view input;
    /// Whether an input is of this kind: by its content wherever that is conclusive, else by its
    /// name. Throws nothing.
    bool (*recognises)(const std::string& input);
    /// @throws UsageError for options that do not apply; Error when it cannot be opened
    std::unique_ptr<voxel::World> (*open)(const OpenRequest& request);
    /// Describes an input in more detail than the opened world does; nullptr where there is no
    /// more.
    /// @throws UsageError for an input that it cannot describe; Error when it cannot be read
    Description (*describe)(const DescribeRequest& request) = nullptr;
    /// Fingerprint of all files that opening and making boxes read: it changes once any of them
    /// does. Costs a stat of each file and little more. Null: the opened world has its own
    /// (World::edition()), or is LiDAR data (voxelize::InputFingerprints).
    /// @throws Error when a file cannot be read
    voxel::Fingerprint (*state)(const WorldOptions& options) = nullptr;
    /// Flags of `terravox serve` that apply to this kind but not to every one, separated by spaces.
    /// --ortho is takes_orthophotos.
    std::string_view flags = {};
    bool is_path = true;         ///< the input is a file or folder of this machine
    bool takes_several = false;  ///< more than one input makes one world
    bool takes_orthophotos = false;
    bool is_archive = false;  ///< the input is a box archive, which can be passed on as it is
    /// The opened world goes on with the files that it was opened with, and detects changes of
    /// these itself: files that are renamed to their names do not concern it.
    bool keeps_its_files = false;
    bool has_squares = false;  ///< LiDAR squares, which can be prepared in the cache folder
    FarmAccess farm_access = FarmAccess::kFromCoordinator;
};

}  // namespace terravox::worlds
