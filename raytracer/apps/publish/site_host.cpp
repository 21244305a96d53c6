#include "raytracer/apps/publish/site_host.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "voxelserver/serve/http/file_reply.hpp"
#include "voxelserver/serve/http/route_answers.hpp"
#include "voxelserver/serve/http/service.hpp"

namespace terravox::publish {
namespace {

namespace fs = std::filesystem;

constexpr http::RouteFacts kFile{.route = http::Route::kPageFile,
                                 .path = "/{file}",
                                 .methods = http::Methods::kGet,
                                 .open = true};

int open_folder(const fs::path& folder) {
    const int out = ::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (out < 0)
        throw util::Error("serve the site " + folder.string() + ": " + std::strerror(errno));
    return out;
}

/// Ref: RFC 3986, 2.1.
/// @return nullopt for a wrong escape
std::optional<std::string> decoded(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            out += text[i];
            continue;
        }
        constexpr std::string_view kDigits = "0123456789abcdef";
        const auto digit = [&](std::size_t at) {
            return at < text.size() ? kDigits.find(util::lower_case(text[at]))
                                    : std::string_view::npos;
        };
        const std::size_t high = digit(i + 1);
        const std::size_t low = digit(i + 2);
        if (high == std::string_view::npos || low == std::string_view::npos)
            return std::nullopt;
        out += static_cast<char>(high << 4 | low);
        i += 2;
    }
    return out;
}

// For browsers a backslash is a slash: with it, an address that a reply names could be another
// host's.
bool is_name(const std::string& name) {
    return !name.empty() && name != "." && name != ".." &&
           std::all_of(name.begin(), name.end(), [](char c) {
               return c != '/' && c != '\\' && static_cast<unsigned char>(c) >= ' ';
           });
}

/// The names in a path; the last is empty where it ends with a slash.
/// @return nullopt for a path that leads to no file of a folder
std::optional<std::vector<std::string>> split_names(std::string_view path) {
    if (!path.starts_with('/'))
        return std::nullopt;
    std::vector<std::string> out;
    for (bool is_last = false; !is_last;) {
        path.remove_prefix(1);
        const std::size_t end = path.find('/');
        is_last = end == std::string_view::npos;
        std::optional<std::string> name = decoded(path.substr(0, end));
        if (!name || (!is_name(*name) && !(is_last && name->empty())))
            return std::nullopt;
        out.push_back(std::move(*name));
        path.remove_prefix(is_last ? path.size() : end);
    }
    return out;
}

std::string_view find_type(const std::string& name) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 12> kTypes = {{
        {".css", "text/css; charset=utf-8"},
        {".html", "text/html; charset=utf-8"},
        {".ico", "image/vnd.microsoft.icon"},
        {".jpg", "image/jpeg"},
        {".js", "text/javascript; charset=utf-8"},
        {".json", "application/json"},
        {".mjs", "text/javascript; charset=utf-8"},
        {".png", "image/png"},
        {".svg", "image/svg+xml"},
        {".tvx", "application/vnd.terravox.archive"},
        {".txt", "text/plain; charset=utf-8"},
        {".webp", "image/webp"},
    }};
    const std::string ending = util::lower_extension(name);
    for (const auto& [known, type] : kTypes)
        if (ending == known)
            return type;
    return "application/octet-stream";
}

/// With a slash at its end a folder's address is the one that relative addresses of its page begin
/// at.
http::Response to_redirect(std::string_view path) {
    const std::string name(path.substr(path.rfind('/') + 1));
    http::Response out = http::reply(308, "text/plain; charset=utf-8", "a folder\n");
    return out.add("Location", "./" + name + "/").add("Cache-Control", "no-store");
}

http::Response no_file(int why, std::string_view path) {
    if (why == EMFILE || why == ENFILE || why == ENOMEM)
        return http::problem(503, "too many files are open").add("Retry-After", "1");
    return http::problem(
        404, "the site has no file " + std::string(path) +
                 (why == ELOOP ? "; it is a symbolic link, which is not followed" : ""));
}

http::HostOptions make_options(std::uint16_t port) {
    constexpr int kThreads = 32;  // a browser has up to six connections
    http::HostOptions out;
    out.port = port;
    out.request_threads = kThreads;
    return out;
}

}  // namespace

SiteFiles::SiteFiles(const fs::path& folder, std::string archive_origin)
    : m_check("", http::HostNames()),
      m_archive_origin(std::move(archive_origin)),
      m_folder(open_folder(folder)) {}

SiteFiles::~SiteFiles() {
    ::close(m_folder);
}

std::optional<http::Response> SiteFiles::refusal(const http::Request& request) {
    const std::size_t bytes = request.path.size() + request.query.size();
    if (bytes > kMaxAddress_bytes)
        return http::problem(414, "an address of " + std::to_string(bytes) +
                                      " bytes; allowed: up to " +
                                      std::to_string(kMaxAddress_bytes));
    return m_check.refusal(kFile, request);
}

http::Response SiteFiles::handle(const http::Request& request) {
    try {
        std::optional<http::Response> refused = refusal(request);
        http::Response out = refused ? std::move(*refused) : answer(request);
        return http::add_page_headers(std::move(out), m_archive_origin);
    } catch (...) {
        return http::reply_to_current_exception(request);
    }
}

http::Response SiteFiles::answer(const http::Request& request) const {
    std::optional<std::vector<std::string>> names = split_names(request.path);
    if (!names)
        return no_file(ENOENT, request.path);
    if (names->back().empty())
        names->back() = "index.html";
    const std::optional<http::OpenFile> file = http::open_file_beneath(m_folder, *names);
    if (file)
        return http::file_reply(request, *file, http::to_etag(*file), find_type(names->back()));
    const int why = errno;
    return why == EISDIR && !request.path.ends_with('/') ? to_redirect(request.path)
                                                         : no_file(why, request.path);
}

SiteHost::SiteHost(const fs::path& folder, std::uint16_t port, std::string archive_origin)
    : m_files(folder, std::move(archive_origin)), m_host(m_files, make_options(port)) {}

}  // namespace terravox::publish
