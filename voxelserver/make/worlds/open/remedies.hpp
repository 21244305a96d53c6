#pragma once

#include <string>

namespace terravox::worlds {

/// What an input that is no world is instead, and what to do with it, for messages: "it is an E57
/// file; translate it: pdal translate a.e57 a.laz". Looks at names, first bytes, and the folders in
/// a folder; reads at most some thousand names.
/// @param input that no kind of world recognises; it need not exist
/// @return "" where nothing is known about it
[[nodiscard]] std::string find_remedy(const std::string& input);

/// The same for an address: "http://host/a.laz" is no voxel server. "" of one that may be.
[[nodiscard]] std::string find_address_remedy(const std::string& address);

}  // namespace terravox::worlds
