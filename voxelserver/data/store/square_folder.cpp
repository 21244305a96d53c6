#include "voxelserver/data/store/square_folder.hpp"

#include <algorithm>
#include <chrono>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/fingerprint.hpp"

namespace terravox::store {

namespace fs = std::filesystem;
namespace {

constexpr const char* kSquare = ".square";
constexpr const char* kIndex = ".chunks";
constexpr const char* kFacts = ".facts";

/// One file of the folder, ordered by eviction.
struct Kept {
    bool small = false;
    fs::file_time_type used;
    fs::path file;
    std::uint64_t bytes = 0;
    /// Squares first, since they are large: an index saves nearly as much time for a hundredth of
    /// the space, and facts for less. Within each kind the least recently used first.
    friend bool operator<(const Kept& a, const Kept& b) {
        return a.small != b.small ? b.small : a.used != b.used ? a.used < b.used : a.file < b.file;
    }
};

// Whether a file is unfinished: being written (AtomicFile gives such names), or left behind by a
// crash.
bool unfinished(const fs::path& file) {
    return file.filename().string().starts_with('.');
}

std::vector<Kept> list_files(const fs::path& folder) {
    std::vector<Kept> out;
    std::error_code failed;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
         entry.increment(failed)) {
        const fs::path& file = entry->path();
        const bool small = file.extension() == kIndex || file.extension() == kFacts;
        if (file.extension() != kSquare && !small)
            continue;
        std::error_code gone;  // already removed by another process
        Kept kept{small, entry->last_write_time(gone), file, 0};
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
    std::vector<Kept> out = list_files(folder);
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

/// @param read from a path; throws Error when the file is damaged
template <class Read>
auto find_file(const fs::path& file, const Read& read) {
    using Found = decltype(read(file));
    try {
        Found found = read(file);
        std::error_code ignored;
        // Marks it as used now: last in the order of eviction.
        if (found)
            fs::last_write_time(file, fs::file_time_type::clock::now(), ignored);
        return found;
    } catch (const util::Error& e) {
        util::log_warn("{}; it is made again", e.what());
        return Found();
    }
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
           voxel::to_hex(facts.fingerprint());
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
fs::path SquareFolder::facts_file(const std::string& name) const {
    return m_folder / (name + kFacts);
}

bool SquareFolder::holds(const std::string& name) const {
    std::error_code ignored;
    return fs::exists(square_file(name), ignored);
}

bool SquareFolder::holds_index(const std::string& name) const {
    std::error_code ignored;
    return fs::exists(index_file(name), ignored);
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

template <class Write>
void SquareFolder::put_small(const fs::path& file, const Write& write) {
    {
        const std::lock_guard lock(m_mutex);
        if (m_read_only)
            return;
    }
    try {
        write(file);
    } catch (const util::Error& e) {
        complain(e.what());
    }
}

std::shared_ptr<const Square> SquareFolder::find(const std::string& name) {
    return find_file(square_file(name), map_square);
}

std::optional<ChunkIndex> SquareFolder::find_index(const std::string& name) {
    return find_file(index_file(name), read_chunks);
}

void SquareFolder::put_index(const std::string& name, const ChunkIndex& index) {
    put_small(index_file(name), [&](const fs::path& file) {
        write_chunks(file, index);
        evict(file);
    });
}

std::optional<std::string> SquareFolder::find_facts(const std::string& name) {
    return find_file(facts_file(name), read_facts);
}

void SquareFolder::put_facts(const std::string& name, const std::string& facts) {
    // They are so small that they need not be counted at once.
    put_small(facts_file(name), [&](const fs::path& file) { write_facts(file, facts); });
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
