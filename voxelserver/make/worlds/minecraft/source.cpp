#include "voxelserver/make/worlds/minecraft/source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <set>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "voxelserver/make/worlds/minecraft/place_names.hpp"

namespace terravox::minecraft {

DiskFile::DiskFile(const std::filesystem::path& path)
    : DiskFile(util::Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC)), path.string()) {}

DiskFile::DiskFile(util::Descriptor file, std::string name)
    : m_file(std::move(file)), m_name(std::move(name)) {
    struct stat status{};
    if (m_file.get() < 0 || ::fstat(m_file.get(), &status) != 0)
        throw util::Error("open {}: {}", m_name, std::strerror(errno));
    m_size = static_cast<std::uint64_t>(status.st_size);
}

void DiskFile::read(std::uint64_t offset, std::span<std::uint8_t> out) const {
    while (!out.empty()) {
        const ssize_t got =
            ::pread(m_file.get(), out.data(), out.size(), static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            throw util::Error("read {}: {}", m_name, std::strerror(errno));
        if (got == 0)
            throw util::Error("read {}: it ends at byte {}", m_name, offset);
        offset += static_cast<std::uint64_t>(got);
        out = out.subspan(static_cast<std::size_t>(got));
    }
}

namespace {

namespace fs = std::filesystem;

// Folders below the given one: Alpha worlds within a folder within a folder need five.
constexpr int kDeepest = 10;

// Lists the files below a folder. Links are followed (servers keep regions on other disks), but no
// folder is entered twice: links may form cycles.
class Lister {
public:
    explicit Lister(fs::path root) : m_root(std::move(root)) {}
    void list() {
        for (m_open.push_back({m_root, "", 0}); !m_open.empty();) {
            const Folder folder = m_open.back();
            m_open.pop_back();
            list(folder);
        }
    }
    std::vector<FileSource::Entry> entries;
    std::vector<std::string> refused;

private:
    struct Folder {
        fs::path path;
        std::string name;
        int depth;
    };
    void list(const Folder& folder) {
        std::error_code failed;
        const fs::path real = fs::canonical(folder.path, failed);
        if (failed || !m_seen.insert(real).second)
            return;
        for (fs::directory_iterator at(folder.path, failed), end; !failed && at != end;
             at.increment(failed))
            add(*at, folder);
        if (!failed)
            return;
        if (folder.depth == 0)
            throw util::Error("read the folder {}: {}", folder.path.string(), failed.message());
        refused.push_back(folder.name + ": " + failed.message());
    }
    void add(const fs::directory_entry& entry, const Folder& folder) {
        const std::string name = joined(folder.name, entry.path().filename().string());
        std::error_code failed;
        if (entry.is_directory(failed)) {
            // Links come last: a folder is listed under its own name where it has one.
            if (folder.depth < kDeepest)
                m_open.insert(entry.is_symlink(failed) ? m_open.begin() : m_open.end(),
                              {entry.path(), name, folder.depth + 1});
            else
                refused.push_back(name + ": deeper than " + std::to_string(kDeepest) + " folders");
        } else if (entry.is_regular_file(failed)) {
            entries.push_back({name, entry.file_size(failed)});
            if (entries.size() > FileSource::kMaxEntries)
                throw util::UsageError(
                    "read the folder {}: more than {} files; allowed: a world's folder",
                    m_root.string(), FileSource::kMaxEntries);
        }
    }

    fs::path m_root;
    std::deque<Folder> m_open;  ///< the last is processed next
    std::set<fs::path> m_seen;
};

class FolderSource final : public FileSource {
public:
    FolderSource(fs::path folder, std::size_t cache_bytes)
        : FileSource(cache_bytes), m_folder(std::move(folder)) {
        Lister lister(m_folder);
        lister.list();
        set_entries(std::move(lister.entries), std::move(lister.refused));
    }
    // One file alone.
    FolderSource(const fs::path& file, std::uint64_t bytes, std::size_t cache_bytes)
        : FileSource(cache_bytes), m_folder(file.parent_path()) {
        set_entries({{file.filename().string(), bytes}}, {});
    }
    std::vector<std::uint8_t> head(std::size_t entry, std::size_t most) override {
        const DiskFile file(m_folder / m_entries[entry].path);
        std::vector<std::uint8_t> out(
            static_cast<std::size_t>(std::min<std::uint64_t>(most, file.size())));
        file.read(0, out);
        return out;
    }

private:
    // Each open file counts as a share of the limit, so that there are not too many.
    Opened open_anew(std::size_t entry) override {
        return {std::make_shared<DiskFile>(m_folder / m_entries[entry].path), std::size_t{1} << 20};
    }

    fs::path m_folder;
};

bool is_zip(const fs::path& file) {
    const std::string magic = util::read_start(file, 4);
    // A file's head, or the end of an archive without files.
    return magic == "PK\x03\x04" || magic == "PK\x05\x06";
}

}  // namespace

void FileSource::set_entries(std::vector<Entry> entries, std::vector<std::string> refused) {
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.path < b.path; });
    m_entries = std::move(entries);
    m_refused = std::move(refused);
}

std::optional<std::size_t> FileSource::find(std::string_view path) const noexcept {
    const auto found =
        std::lower_bound(m_entries.begin(), m_entries.end(), path,
                         [](const Entry& e, std::string_view p) { return e.path < p; });
    if (found == m_entries.end() || found->path != path)
        return std::nullopt;
    return static_cast<std::size_t>(found - m_entries.begin());
}

// An entry that cannot be opened is not tried again: a bomb would be unpacked once for each of its
// chunks.
std::shared_ptr<const ByteFile> FileSource::open(std::size_t entry) {
    {
        const std::lock_guard lock(m_failed_mutex);
        if (const auto failed = m_failed.find(entry); failed != m_failed.end())
            throw util::Error(failed->second);
    }
    try {
        const auto make = [&] { return std::make_shared<const Opened>(open_anew(entry)); };
        return m_open.get(entry, make, [](const auto& made) { return made->weight_bytes; })->file;
    } catch (const util::Error& e) {
        const std::lock_guard lock(m_failed_mutex);
        m_failed.emplace(entry, e.what());
        throw;
    }
}

std::vector<std::uint8_t> FileSource::whole(std::size_t entry, std::size_t most) {
    std::vector<std::uint8_t> out = head(entry, most + 1);
    if (out.size() > most)
        throw util::Error("read {}: more than {} bytes, the most that is allowed",
                          m_entries[entry].path, most);
    return out;
}

std::unique_ptr<FileSource> open_source(const fs::path& path, std::size_t cache_bytes) {
    std::error_code failed;
    const fs::file_status status = fs::status(path, failed);
    if (!fs::exists(status))
        throw util::UsageError("open the Minecraft world {}: there is no such file or folder",
                               path.string());
    try {
        if (fs::is_directory(status))
            return std::make_unique<FolderSource>(path, cache_bytes);
        if (!fs::is_regular_file(status))
            throw util::UsageError("open the Minecraft world {}: neither a file nor a folder",
                                   path.string());
        if (is_zip(path))
            return open_zip(path, cache_bytes);
        return std::make_unique<FolderSource>(path, fs::file_size(path), cache_bytes);
    } catch (const fs::filesystem_error& e) {
        throw util::Error("open the Minecraft world {}: {}", path.string(), e.code().message());
    }
}

}  // namespace terravox::minecraft
