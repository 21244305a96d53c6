#include "voxelserver/serve/http/file_reply.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {
namespace {

/// Where If-Range has something else than the tag, such as a date, the client gets the whole file.
std::optional<ByteRange> wanted_range(const Request& request, const OpenFile& file,
                                      std::string_view etag) {
    if (request.method != "GET")
        return std::nullopt;
    const std::string only_if = request.header("If-Range");
    if (!only_if.empty() && only_if != etag)
        return std::nullopt;
    return parse_range(request.header("Range"), file.bytes);
}

// A pipe would block until it has a writer.
constexpr int kReading = O_RDONLY | O_CLOEXEC | O_NONBLOCK;

std::shared_ptr<const int> to_owner(int descriptor) {
    return {new int(descriptor), [](const int* one) {
                ::close(*one);
                delete one;
            }};
}

/// @param descriptor -1: errno says why
std::optional<OpenFile> to_open_file(int descriptor) {
    if (descriptor < 0)
        return std::nullopt;
    OpenFile out;
    out.descriptor = to_owner(descriptor);
    struct stat facts{};
    if (::fstat(descriptor, &facts) != 0)
        return std::nullopt;
    if (!S_ISREG(facts.st_mode)) {
        errno = EISDIR;
        return std::nullopt;
    }
    constexpr std::int64_t kNs = 1'000'000'000;
    out.bytes = static_cast<std::uint64_t>(facts.st_size);
    out.changed_ns = facts.st_mtim.tv_sec * kNs + facts.st_mtim.tv_nsec;
    return out;
}

}  // namespace

std::optional<OpenFile> open_file(const std::filesystem::path& path, bool follow) {
    return to_open_file(::open(path.c_str(), kReading | (follow ? 0 : O_NOFOLLOW)));
}

// One folder at a time: O_NOFOLLOW is about the last name only. openat2(RESOLVE_BENEATH) would do
// it in one call, but is missing before Linux 5.6 and forbidden in many containers.
std::optional<OpenFile> open_file_beneath(int folder, std::span<const std::string> names) {
    std::shared_ptr<const int> owner;
    for (const std::string& name : names.first(names.size() - 1)) {
        folder = ::openat(folder, name.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
        if (folder < 0)
            return std::nullopt;
        owner = to_owner(folder);
    }
    return to_open_file(::openat(folder, names.back().c_str(), kReading | O_NOFOLLOW));
}

std::string to_etag(const OpenFile& file) {
    return fmt::format("\"{:x}-{:x}\"", file.bytes, static_cast<std::uint64_t>(file.changed_ns));
}

Response file_reply(const Request& request, const OpenFile& file, std::string_view etag,
                    std::string_view content_type) {
    const std::string only_for = request.header("If-Match");
    if (!only_for.empty() && !etag_matches_strongly(only_for, etag)) {
        Response out = problem(412, "the file is another one than the request wants");
        return out.add("ETag", etag);
    }
    if (etag_matches(request.header("If-None-Match"), etag))
        return not_modified(etag);
    const std::optional<ByteRange> range = wanted_range(request, file, etag);
    const std::string size = std::to_string(file.bytes);
    if (range && range->bytes == 0)
        return problem(416, "the file has " + size + " bytes")
            .add("Content-Range", "bytes */" + size)
            .add("ETag", etag);
    Response out;
    out.add("Content-Type", content_type).add("Accept-Ranges", "bytes");
    add_validators(out, etag);
    out.file =
        FilePart{file.descriptor, range ? range->offset : 0, range ? range->bytes : file.bytes};
    if (range) {
        out.status = 206;
        out.add("Content-Range", "bytes " + std::to_string(range->offset) + "-" +
                                     std::to_string(range->offset + range->bytes - 1) + "/" + size);
    }
    return out;
}

}  // namespace terravox::http
