#include "voxelserver/store/square_folder.hpp"

#include <spdlog/spdlog.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <vector>

#include "common/util/error.hpp"
#include "voxelserver/store/square_file.hpp"

namespace terravox::store {

namespace fs = std::filesystem;

std::string square_name(const lidar::LasInfo& info, const std::string& recipe) {
    // The file's size, time, beginning and end: reading all of it would cost as much as what the folder saves.
    constexpr std::size_t kEnds = 65536;
    std::error_code ignored;
    const auto time = fs::last_write_time(info.path, ignored).time_since_epoch().count();
    std::string facts = recipe + "|" + std::to_string(info.file_bytes) + "|" + std::to_string(time) + "|";
    std::ifstream in(info.path, std::ios::binary);
    std::vector<char> part(std::min<std::uint64_t>(kEnds, info.file_bytes));
    in.read(part.data(), static_cast<std::streamsize>(part.size()));
    facts.append(part.begin(), part.end());
    in.seekg(-static_cast<std::streamoff>(part.size()), std::ios::end);
    in.read(part.data(), static_cast<std::streamsize>(part.size()));
    if (!in) throw Error("read the point cloud " + info.path.string() + ": cannot be read");
    facts.append(part.begin(), part.end());
    const XXH128_hash_t hash = XXH3_128bits(facts.data(), facts.size());
    std::array<char, 33> text{};
    std::snprintf(text.data(), text.size(), "%016llx%016llx", static_cast<unsigned long long>(hash.high64), static_cast<unsigned long long>(hash.low64));
    return info.path.stem().string() + "-" + text.data();
}

SquareFolder::SquareFolder(fs::path folder, std::uint64_t limit_bytes) : m_folder(std::move(folder)), m_limit_bytes(limit_bytes) {
    std::error_code failed;
    fs::create_directories(m_folder, failed);
    if (failed || !fs::is_directory(m_folder)) throw Error("make the cache folder " + m_folder.string() + ": " + (failed ? failed.message() : "not a folder"));
}

bool SquareFolder::holds(const std::string& name) const {
    std::error_code ignored;
    return fs::exists(square_file(name), ignored);
}

std::shared_ptr<const voxelize::Square> SquareFolder::find(const std::string& name) {
    const fs::path file = square_file(name);
    try {
        auto square = map_square(file);
        std::error_code ignored;
        if (square) fs::last_write_time(file, fs::file_time_type::clock::now(), ignored);  // used now: the last to go
        return square;
    } catch (const Error& e) {
        spdlog::warn("{}; it is made again", e.what());
        return nullptr;
    }
}

std::shared_ptr<const voxelize::Square> SquareFolder::put(const std::string& name, std::shared_ptr<const voxelize::Square> square) {
    {
        const std::lock_guard lock(m_mutex);
        if (m_read_only || square->memory_bytes() > m_limit_bytes) return square;
    }
    const fs::path file = square_file(name);
    try {
        write_square(file, *square);
        evict(file);
        if (auto mapped = map_square(file)) return mapped;
    } catch (const Error& e) {
        complain(e.what());
    }
    return square;
}

std::optional<voxelize::ChunkIndex> SquareFolder::find_index(const std::string& name) {
    try {
        return read_chunks(index_file(name));
    } catch (const Error& e) {
        spdlog::warn("{}; it is made again", e.what());
        return std::nullopt;
    }
}

void SquareFolder::put_index(const std::string& name, const voxelize::ChunkIndex& index) {
    {
        const std::lock_guard lock(m_mutex);
        if (m_read_only) return;
    }
    try {
        write_chunks(index_file(name), index);
    } catch (const Error& e) {
        complain(e.what());
    }
}

void SquareFolder::complain(const std::string& what) {
    const std::lock_guard lock(m_mutex);
    if (!m_read_only) spdlog::warn("{}; prepared squares are kept in memory only", what);
    m_read_only = true;
}

void SquareFolder::evict(const fs::path& but_not) {
    const std::lock_guard lock(m_mutex);
    struct Kept {
        fs::file_time_type used;
        fs::path file;
        std::uint64_t bytes;
    };
    std::vector<Kept> kept;
    std::uint64_t total = 0;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(m_folder, ignored)) {
        if (entry.path().extension() != ".square") continue;
        const std::uint64_t bytes = entry.file_size(ignored);
        if (ignored) continue;  // another process was faster
        kept.push_back({entry.last_write_time(ignored), entry.path(), bytes});
        total += bytes;
    }
    std::sort(kept.begin(), kept.end(), [](const Kept& a, const Kept& b) { return a.used < b.used; });
    for (const Kept& k : kept) {
        if (total <= m_limit_bytes) break;
        if (k.file == but_not) continue;
        if (fs::remove(k.file, ignored)) total -= k.bytes;
    }
}

}  // namespace terravox::store
