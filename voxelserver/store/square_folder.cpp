#include "voxelserver/store/square_folder.hpp"

#include <algorithm>
#include <chrono>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/bytes.hpp"
#include "common/voxel/file_identity.hpp"
#include "voxelserver/store/square_file.hpp"

namespace terravox::store {

namespace fs = std::filesystem;
namespace {

constexpr const char *kSquare = ".square", *kIndex = ".chunks";

/// One file of the folder, ordered by eviction.
struct Kept {
    bool index = false;
    fs::file_time_type used;
    fs::path file;
    std::uint64_t bytes = 0;
    /// Squares first, since they are large: an index saves nearly as much time for a hundredth of
    /// the space. Within each kind the least recently used first.
    friend bool operator<(const Kept& a, const Kept& b) {
        return a.index != b.index ? b.index : a.used != b.used ? a.used < b.used : a.file < b.file;
    }
};

// Whether a file is unfinished: being written (AtomicFile gives such names), or left behind by a
// crash.
bool unfinished(const fs::path& file) {
    return file.filename().string().starts_with('.');
}

std::vector<Kept> files_of(const fs::path& folder) {
    std::vector<Kept> out;
    std::error_code failed;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
         entry.increment(failed)) {
        const fs::path& file = entry->path();
        if (file.extension() != kSquare && file.extension() != kIndex)
            continue;
        std::error_code gone;  // already removed by another process
        Kept kept{file.extension() == kIndex, entry->last_write_time(gone), file, 0};
        if (!gone)
            kept.bytes = entry->file_size(gone);
        if (!gone)
            out.push_back(std::move(kept));
    }
    return out;
}

/// Removes files that were left unfinished long ago.
std::vector<Kept> finished_files(const fs::path& folder) {
    constexpr auto kAbandoned = std::chrono::hours(1);  // no square takes so long to write
    std::vector<Kept> out = files_of(folder);
    std::erase_if(out, [&](const Kept& k) {
        if (!unfinished(k.file))
            return false;
        std::error_code ignored;
        // It may still be being written: it counts once it is complete.
        if (fs::file_time_type::clock::now() - k.used > kAbandoned)
            fs::remove(k.file, ignored);
        return true;
    });
    return out;
}

}  // namespace

std::string square_name(const fs::path& source, const std::string& recipe) {
    return square_name(source, voxel::file_identity(source, "point cloud"), recipe);
}

std::string square_name(const fs::path& source, const voxel::Fingerprint& identity,
                        const std::string& recipe) {
    voxel::ByteWriter facts;
    facts.add(recipe);
    facts.add(identity);
    // The stem is for readers: truncated so that no name gets too long, and without the dots that
    // mark unfinished files.
    constexpr std::size_t kStem = 80;
    const std::string stem = source.stem().string();
    return stem.substr(std::min(stem.find_first_not_of('.'), stem.size())).substr(0, kStem) + "-" +
           voxel::hex_of(facts.fingerprint());
}

SquareFolder::SquareFolder(fs::path folder, std::uint64_t limit_bytes)
    : m_folder(std::move(folder)), m_limit_bytes(limit_bytes) {
    std::error_code failed;
    fs::create_directories(m_folder, failed);
    std::error_code ignored;
    if (failed || !fs::is_directory(m_folder, ignored))
        complain("make the folder " + m_folder.string() + ": " +
                 (failed ? failed.message() : "not a folder"));
    // Nothing else ever looks at all files of such a folder.
    if (m_limit_bytes == kUnlimited_bytes)
        (void)finished_files(m_folder);
}

fs::path SquareFolder::square_file(const std::string& name) const {
    return m_folder / (name + kSquare);
}
fs::path SquareFolder::index_file(const std::string& name) const {
    return m_folder / (name + kIndex);
}

bool SquareFolder::holds(const std::string& name) const {
    std::error_code ignored;
    return fs::exists(square_file(name), ignored);
}

bool SquareFolder::holds_index(const std::string& name) const {
    std::error_code ignored;
    return fs::exists(index_file(name), ignored);
}

std::shared_ptr<const Square> SquareFolder::find(const std::string& name) {
    const fs::path file = square_file(name);
    try {
        auto square = map_square(file);
        std::error_code ignored;
        // Marks it as used now: last in the order of eviction.
        if (square)
            fs::last_write_time(file, fs::file_time_type::clock::now(), ignored);
        return square;
    } catch (const util::Error& e) {
        util::log_warn("{}; it is made again", e.what());
        return nullptr;
    }
}

std::shared_ptr<const Square> SquareFolder::put(const std::string& name,
                                                std::shared_ptr<const Square> square) {
    {
        const std::lock_guard lock(m_mutex);
        if (m_read_only || square->memory_bytes() > m_limit_bytes)
            return square;
    }
    const fs::path file = square_file(name);
    try {
        write_square(file, *square);
        evict(file);
        if (auto mapped = map_square(file))
            return mapped;
    } catch (const util::Error& e) {
        complain(e.what());
    }
    return square;
}

std::optional<ChunkIndex> SquareFolder::find_index(const std::string& name) {
    try {
        auto index = read_chunks(index_file(name));
        std::error_code ignored;
        if (index)
            fs::last_write_time(index_file(name), fs::file_time_type::clock::now(), ignored);
        return index;
    } catch (const util::Error& e) {
        util::log_warn("{}; it is made again", e.what());
        return std::nullopt;
    }
}

void SquareFolder::put_index(const std::string& name, const ChunkIndex& index) {
    {
        const std::lock_guard lock(m_mutex);
        if (m_read_only)
            return;
    }
    const fs::path file = index_file(name);
    try {
        write_chunks(file, index);
        evict(file);
    } catch (const util::Error& e) {
        complain(e.what());
    }
}

void SquareFolder::complain(const std::string& what) {
    const std::lock_guard lock(m_mutex);
    if (!m_read_only)
        util::log_warn("{}; nothing more is kept in this folder", what);
    m_read_only = true;
}

void SquareFolder::evict(const fs::path& but_not) {
    if (m_limit_bytes == kUnlimited_bytes)
        return;
    const std::lock_guard lock(m_mutex);
    std::vector<Kept> kept = finished_files(m_folder);
    std::error_code ignored;
    std::sort(kept.begin(), kept.end());
    std::uint64_t total = 0;
    for (const Kept& k : kept)
        total += k.bytes;
    for (const Kept& k : kept) {
        if (total <= m_limit_bytes)
            break;
        if (k.file == but_not)
            continue;
        if (fs::remove(k.file, ignored) || !ignored)
            total -= k.bytes;
    }
    // Larger than the limit on its own.
    if (total > m_limit_bytes)
        fs::remove(but_not, ignored);
}

}  // namespace terravox::store
