#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "voxelserver/serve/host/message.hpp"

namespace terravox::http {

/// A plain file that stays open: a reply under way goes on with it when another one is renamed to
/// its name.
struct OpenFile {
    std::shared_ptr<const int> descriptor;  ///< closed with the last owner
    std::uint64_t bytes = 0;
    std::int64_t changed_ns = 0;  ///< time of the last change of its bytes, since 1970
};

/// @param follow whether a symbolic link leads to the file
/// @return nullopt where there is no plain file that can be read; errno says why, EISDIR for what
/// is no plain file
[[nodiscard]] std::optional<OpenFile> open_file(const std::filesystem::path& path, bool follow);

/// Opens a plain file by the names of its folders, from an open folder on, and its own. None of
/// them may be a symbolic link: so nothing outside of the folder is opened, whoever writes to it.
/// @param folder descriptor
/// @param names not empty; none is empty, "." or "..", none holds a slash or a zero
/// @return as open_file(); ELOOP or ENOTDIR for a link
[[nodiscard]] std::optional<OpenFile> open_file_beneath(int folder,
                                                        std::span<const std::string> names);

/// Another state of the file has another tag, made of its size and its time. Strong, with quotes.
[[nodiscard]] std::string to_etag(const OpenFile& file);

/// The reply to GET and HEAD of a file: all of it, or the one range that a GET names.
///
/// 412 for an If-Match without the tag, 304 for an If-None-Match with it, 206 or 416 for a range,
/// which is ignored where If-Range has another tag. Clients revalidate what they keep, as
/// add_validators() says. Ref: RFC 9110, 13 and 14.
/// @param etag strong, with its quotes: another state of the file has another one
[[nodiscard]] Response file_reply(const Request& request, const OpenFile& file,
                                  std::string_view etag, std::string_view content_type);

}  // namespace terravox::http
