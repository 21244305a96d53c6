#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace terravox {

/// What a world can be made from.
enum class Origin : std::uint8_t {
    kServer,      ///< the address of a voxel server
    kFarArchive,  ///< the address of a box archive
    kArchive,     ///< a box archive
    kGenerated,   ///< "generated" or "generated:SEED"
    kMinecraft,   ///< a Minecraft world: folder, ZIP, region or chunk
    kStore,       ///< the grabber's store
    kRelief,      ///< a raster of heights, or a folder of them
    kLidar,       ///< LAS, LAZ or COPC files, or folders of them
};

/// What all of them are, for messages and help.
inline constexpr std::string_view kOrigins =
    "LAS, LAZ or COPC files, the grabber's store, a raster of heights, a Minecraft world (folder "
    "or ZIP), a box archive (.tvx), generated:SEED, or the "
    "http:// address of a voxel server or box archive";

/// By what it is, not by what it is called, wherever a look into it can tell.
/// @throws UsageError for a path that does not exist, or is nothing that a world can be made from
[[nodiscard]] Origin recognise(const std::string& input);

[[nodiscard]] std::string_view name_of(
    Origin origin) noexcept;  ///< "a Minecraft world", for messages

}  // namespace terravox
