#include "raytracer/apps/publish/site_folder.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "raytracer/apps/publish/site.hpp"
#include "voxelserver/serve/page/assets.hpp"

namespace terravox::publish {
namespace {

namespace fs = std::filesystem;

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
