#include "voxelserver/http/file_reply.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "voxelserver/http/service.hpp"

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

}  // namespace

std::optional<OpenFile> open_file(const std::filesystem::path& path, bool follow) {
    // A pipe would block until it has a writer.
    const int flags = O_RDONLY | O_CLOEXEC | O_NONBLOCK | (follow ? 0 : O_NOFOLLOW);
    const int descriptor = ::open(path.c_str(), flags);
    if (descriptor < 0)
        return std::nullopt;
    OpenFile out;
    out.descriptor = {new int(descriptor), [](const int* one) {
                          ::close(*one);
                          delete one;
                      }};
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
