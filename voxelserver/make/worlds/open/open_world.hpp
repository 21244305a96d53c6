#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <stop_token>
#include <string>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_kind.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"

namespace terravox::worlds {

/// All kinds, in the order in which they are tried on an input.
[[nodiscard]] std::span<const WorldKind* const> world_kinds() noexcept;

/// The possible inputs, as a list for messages and help.
[[nodiscard]] std::string allowed_inputs();

/// The kind of an input: the first of world_kinds() that recognises it.
/// @throws UsageError for a path that does not exist, or that no kind recognises
[[nodiscard]] const WorldKind& find_kind(const std::string& input);

/// What an input that is no world is instead, and what to do with it, for messages: "it is an E57
/// file; translate it: pdal translate a.e57 a.laz". Looks at names, first bytes, and the folders in
/// a folder; reads at most some thousand names.
/// @param input that no kind of world recognises; it need not exist
/// @return "" where nothing is known about it
[[nodiscard]] std::string find_remedy(const std::string& input);

/// The same for an address: "http://host/a.laz" is no voxel server. "" of one that may be.
[[nodiscard]] std::string find_address_remedy(const std::string& address);

/// Opens the inputs of `options` (world_kinds()). The token of a voxel server comes from
/// access_of_environment().
/// @param times receives the time of every step; outlives the world
/// @param stop of a voxel server or a remote archive: once requested, opening and every later
/// request end within about a second, by an Error; also ends reading the additions
/// @throws UsageError for no input, or for inputs of several kinds; Error when it cannot be opened
[[nodiscard]] std::unique_ptr<voxel::World> open_world(const WorldOptions& options,
                                                       util::StageTimes& times,
                                                       const std::stop_token& stop = {});

/// Puts a world on a plane (overlay/plane_world.hpp).
/// @param plane "table" or "sea"; else the world stays as it is
[[nodiscard]] std::unique_ptr<voxel::World> with_plane(std::unique_ptr<voxel::World> world,
                                                       const std::string& plane);

/// Opens the address of a voxel server or of a box archive.
/// @param access the origins that it may contact, and the token that it sends
/// @param timeout for each request
/// @throws UsageError for any other text; Error when it cannot be opened
[[nodiscard]] std::unique_ptr<voxel::World> open_address(const std::string& url,
                                                         const remote::HttpAccess& access,
                                                         util::StageTimes& times,
                                                         std::chrono::milliseconds timeout,
                                                         const std::stop_token& stop = {});

}  // namespace terravox::worlds
