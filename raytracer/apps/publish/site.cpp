#include "raytracer/apps/publish/site.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "common/voxel/archive/byte_source.hpp"
#include "voxelserver/serve/page/assets.hpp"

namespace terravox::publish {
namespace {

using util::escaped_markup;

namespace fs = std::filesystem;
using nlohmann::json;

json point(core::Vec3 v) {
    return json::array({v.x, v.y, v.z});
}

std::string_view page_file(std::string_view name) {
    const page::Asset* asset = page::find(name);
    if (asset == nullptr)
        throw util::Error("publish: this program lacks the viewer's " + std::string(name));
    return asset->bytes;
}

// What an earlier site has left.
void remove_leftovers(const fs::path& folder, const SiteFacts& facts) {
    const auto is_listed = [&](const std::string& name) {
        return std::any_of(facts.archive.begin(), facts.archive.end(),
                           [&](const archive_tools::FilePart& part) { return part.name == name; });
    };
    std::vector<fs::path> left;
    for (const auto& entry : fs::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if ((name == kSiteArchive && !is_listed(name)) ||
            (name == kSitePreview && !facts.has_preview) ||
            (name == kSiteSquares && facts.squares.empty()))
            left.push_back(entry.path());
    }
    for (const fs::path& part : archive_tools::parts_in(folder, fs::path(kSiteArchive).stem()))
        if (!is_listed(part.filename().string()))
            left.push_back(part);
    for (const fs::path& file : left)
        fs::remove(file);
}

constexpr std::string_view kScheme = "https://";

bool is_visible(char c) noexcept {
    return c > ' ' && c <= '~';
}

// The host of an address with a scheme, with port and user; empty for relative references.
std::string_view find_authority(std::string_view url) noexcept {
    constexpr std::string_view kSlashes = "//";
    const auto at = url.find(kSlashes);
    if (at == std::string_view::npos)
        return {};
    const std::string_view rest = url.substr(at + kSlashes.size());
    return rest.substr(0, rest.find_first_of("/?"));
}

}  // namespace

void check_archive_url(const std::string& url) {
    const std::string_view path = std::string_view(url).substr(0, url.find_first_of("/?"));
    const bool is_absolute = url.starts_with(kScheme);
    const bool is_relative =
        !url.empty() && path.find(':') == std::string_view::npos && !url.starts_with("//");
    const std::string_view host = is_absolute ? find_authority(url) : std::string_view();
    const bool is_plain = std::all_of(url.begin(), url.end(), is_visible) &&
                          url.find_first_of("#\\\"<>") == std::string::npos;
    if ((is_absolute ? host.empty() || host.find('@') != std::string_view::npos : !is_relative) ||
        !is_plain || url.size() > kMaxText_bytes)
        throw util::UsageError(
            "publish: --archive-url " + url +
            "; allowed: https://HOST/PATH without a user or #, or an address relative to the page, "
            "such as ../places/valley.tvx; browsers read no archive of another host over http");
}

std::string to_origin(const std::string& url) {
    try {
        check_archive_url(url);
    } catch (const util::UsageError&) {
        return {};
    }
    if (!url.starts_with(kScheme))
        return {};
    const std::string_view host = find_authority(url);
    // In a policy other characters have a meaning of their own.
    const bool is_plain = std::all_of(host.begin(), host.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               std::string_view("-.:[]").find(c) != std::string_view::npos;
    });
    return is_plain ? std::string(kScheme) + std::string(host) : std::string();
}

std::optional<FoundSite> read_site(const fs::path& folder) {
    constexpr std::size_t kMax_bytes = std::size_t{1} << 20;
    // It has lists in lists in objects. What is deeper is left out, as the file may be a
    // stranger's.
    constexpr int kMaxDepth = 8;
    const fs::path file = folder / kSitePlace;
    std::error_code failed;
    if (!fs::is_regular_file(fs::symlink_status(file, failed)))
        return std::nullopt;
    const auto text = util::try_read_text(file, kMax_bytes);
    if (!text)
        return std::nullopt;
    const auto is_shallow = [](int depth, json::parse_event_t, const json&) {
        return depth <= kMaxDepth;
    };
    const json place = json::parse(*text, is_shallow, false);
    if (!place.is_object())
        return std::nullopt;
    const auto has = [&](const char* name, json::value_t type) {
        return place.contains(name) && place[name].type() == type;
    };
    if (!place.contains("version") || !has("archive", json::value_t::object) ||
        !has("views", json::value_t::array))
        return std::nullopt;
    const json& archive = place["archive"];
    FoundSite out;
    if (const auto url = archive.find("url"); url != archive.end() && url->is_string())
        out.archive_url = *url;
    return out;
}

void copy_archive(const fs::path& from, const fs::path& to) {
    std::error_code same;
    if (fs::equivalent(from, to, same))
        return;
    const voxel::archive::FileState state = voxel::archive::file_state(from);
    const auto archive = voxel::archive::file_source(from, state);
    util::AtomicFile file(to, util::Links::kReplace);
    archive_tools::append_stretch(*archive, 0, state.bytes, file);
    file.commit();
}

std::string place_json(const SiteFacts& facts) {
    json archive;
    if (facts.archive.size() == 1) {
        archive["url"] = facts.archive.front().name;
    } else {
        for (const archive_tools::FilePart& part : facts.archive)
            archive["parts"].push_back({{"url", part.name}, {"bytes", part.bytes}});
    }
    json views = json::array();
    for (const SiteView& view : facts.views) {
        json out{{"name", view.name},
                 {"position", point(view.position)},
                 {"target", point(view.target)},
                 {"fov_deg", view.fov_deg}};
        if (view.frame)
            out["frame"] = {{"min", view.frame->min}, {"max", view.frame->max}};
        views.push_back(std::move(out));
    }
    json place{{"version", 1},
               {"title", facts.title},
               {"attribution", facts.attribution},
               {"licence", facts.licence},
               {"archive", archive},
               {"views", views},
               {"time_ms", facts.time_ms}};
    if (!facts.squares.empty())
        place["squares"] = kSiteSquares;
    return place.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

std::string squares_json(const std::vector<SiteSquare>& squares) {
    json features = json::array();
    for (const auto& [name, west, south, east, north] : squares)
        features.push_back(
            {{"type", "Feature"},
             {"geometry",
              {{"type", "Polygon"},
               {"coordinates",
                {{{west, south}, {east, south}, {east, north}, {west, north}, {west, south}}}}}},
             {"properties", {{"name", name}}}});
    const json out = {{"type", "FeatureCollection"}, {"features", features}};
    return out.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

std::string index_html(const SiteFacts& facts) {
    constexpr std::string_view kTitle = "<title>Terravox</title>\n";
    std::string page(page_file("viewer.html"));
    const auto at = page.find(kTitle);
    if (at == std::string::npos)
        throw util::Error("publish: the viewer's page has no title to replace");
    const std::string title = escaped_markup(facts.title);
    std::string about = "A place of voxels to fly through, with the light of any day.";
    if (!facts.attribution.empty())
        about += " " + facts.attribution;
    const auto meta = [](const std::string& name, const std::string& content) {
        return "<meta property=\"" + name + "\" content=\"" + content + "\">\n";
    };
    std::string head = "<title>" + title + "</title>\n<meta name=\"description\" content=\"" +
                       escaped_markup(about) + "\">\n" + meta("og:title", title) +
                       meta("og:type", "website") + meta("og:description", escaped_markup(about));
    if (facts.has_preview)
        head += meta("og:image", kSitePreview);
    page.replace(at, kTitle.size(), head);
    return page;
}

void write_site(const fs::path& folder, const SiteFacts& facts) {
    for (const std::string_view name : page::kViewerFiles)
        util::write_file_atomically(folder / "viewer" / name, page_file(name),
                                    util::Links::kReplace);
    if (!facts.squares.empty())
        util::write_file_atomically(folder / kSiteSquares, squares_json(facts.squares),
                                    util::Links::kReplace);
    util::write_file_atomically(folder / kSitePlace, place_json(facts), util::Links::kReplace);
    util::write_file_atomically(folder / kSitePage, index_html(facts), util::Links::kReplace);
    remove_leftovers(folder, facts);
}

namespace {

std::vector<std::string> names_in(const fs::path& folder) {
    std::vector<std::string> out;
    std::error_code failed;
    for (fs::directory_iterator it(folder, failed), end; !failed && it != end; it.increment(failed))
        out.push_back(it->path().filename().string());
    if (failed && failed != std::errc::no_such_file_or_directory)
        throw util::Error("publish to " + folder.string() + ": " + failed.message());
    std::sort(out.begin(), out.end());
    return out;
}

/// A file that no run of publish has put into the folder; empty: there is none.
std::string find_foreign(const fs::path& folder, const fs::path& input) {
    std::string out;
    for (const std::string& name : names_in(folder)) {
        std::error_code failed;
        const bool is_input = !input.empty() && fs::equivalent(folder / name, input, failed);
        if (out.empty() && name != kSiteLock && !is_input)
            out = name;
    }
    return out.empty() || read_site(folder) ? std::string() : out;
}

/// Whether a run that was killed has begun a site there.
bool is_begun(const fs::path& folder) {
    std::error_code failed;
    return fs::is_regular_file(fs::symlink_status(folder / kSiteLock, failed));
}

/// The name of the file that an unfinished one of util::AtomicFile, ".STEM.part-PID-DIGITS.ENDING",
/// was to become; empty for any other name.
std::string finished_name(const fs::path& file) {
    constexpr std::string_view kPart = ".part-";
    const std::string stem = file.stem().string();
    const auto part = stem.rfind(kPart);
    if (!stem.starts_with('.') || part == std::string::npos || part < 2)
        return {};
    const std::string numbers = stem.substr(part + kPart.size());
    const bool are_numbers = numbers.find_first_not_of("0123456789abcdef-") == std::string::npos &&
                             std::count(numbers.begin(), numbers.end(), '-') == 1;
    return are_numbers ? stem.substr(1, part - 1) + file.extension().string() : std::string();
}

bool is_of_site(const std::string& name) {
    constexpr std::array<std::string_view, 6> kFiles = {
        kSiteAppearance, kSiteArchive, kSitePage, kSitePlace, kSitePreview, kSiteSquares};
    return std::find(kFiles.begin(), kFiles.end(), name) != kFiles.end() ||
           archive_tools::is_part(name, fs::path(kSiteArchive).stem().string());
}

bool is_of_viewer(const std::string& name) {
    const auto& files = page::kViewerFiles;
    return std::find(files.begin(), files.end(), name) != files.end();
}

void remove_unfinished_in(const fs::path& folder, bool (*is_ours)(const std::string& name)) {
    for (const std::string& name : names_in(folder))
        if (is_ours(finished_name(name)))
            fs::remove(folder / name);
}

}  // namespace

SiteFolder::SiteFolder(fs::path folder, const fs::path& input, bool overwrite)
    : m_path(std::move(folder)), m_input(input) {
    std::error_code failed;
    (void)fs::status(m_path / kSiteLock, failed);
    if (failed == std::errc::not_a_directory)
        throw util::UsageError("publish to " + m_path.string() +
                               ": it is a file; allowed: a new or empty folder, or that of a site");
    const bool may_be_foreign = !overwrite && !is_begun(m_path);
    if (const std::string other = may_be_foreign ? find_foreign(m_path, m_input) : std::string();
        !other.empty())
        throw util::UsageError("publish to " + m_path.string() + ": the folder holds " + other +
                               ", and no site; allowed: a new or empty folder, that of a site, or "
                               "--overwrite");
    util::check_writable(m_path / kSiteLock);
    take_lock();
    remove_unfinished();
}

SiteFolder::~SiteFolder() {
    try {
        // Before the lock ends: it is that of this process.
        if (find_foreign(m_path, m_input).empty())
            fs::remove(m_path / kSiteLock);
    } catch (const std::exception& e) {
        util::log_debug("{}", e.what());  // the next run takes the file over
    }
}

void SiteFolder::take_lock() {
    const fs::path file = m_path / kSiteLock;
    m_lock = util::FileLock::try_take(file);
    if (!m_lock)
        throw util::Error("publish to " + m_path.string() + ": " + util::FileLock::holder(file) +
                          " writes a site there; wait for its end, or choose another folder");
}

void SiteFolder::remove_unfinished() const {
    remove_unfinished_in(m_path, is_of_site);
    remove_unfinished_in(m_path / "viewer", is_of_viewer);
}

}  // namespace terravox::publish
