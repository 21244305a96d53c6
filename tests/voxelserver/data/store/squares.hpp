#pragma once

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "tests/common/content.hpp"
#include "voxelserver/data/store/square.hpp"

namespace terravox::test {

using SquarePtr = std::shared_ptr<const store::Square>;

/// A square of random points in random patches. The same seed makes the same square.
inline SquarePtr made_square(unsigned seed, std::size_t points, int patches) {
    std::mt19937 random(seed);
    store::PatchedPoints part;
    store::PointCounts counts;
    for (std::size_t i = 0; i < points; ++i) {
        store::VoxelPoint p;
        p.x = static_cast<std::uint16_t>(random());
        p.z = static_cast<std::uint16_t>(random());
        p.y = static_cast<std::int32_t>(random() % 4'000'000) - 2'000'000;
        p.source_class = static_cast<std::uint8_t>(random());
        p.colour = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()),
                    static_cast<std::uint8_t>(random())};
        const int patch = static_cast<int>(random() % static_cast<unsigned>(patches));
        part.add({patch % 5 - 2, patch / 5 - 1}, p);
        ++counts.kept;
        ++counts.by_class[p.source_class];
    }
    counts.outliers = seed;
    counts.noise = points / 3;
    counts.withheld = 7;
    return store::bin_points({std::move(part)}, counts, 1);
}

inline bool same_points(std::span<const store::VoxelPoint> a,
                        std::span<const store::VoxelPoint> b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

/// Whether both hold the same points in the same patches. @throws Error for a patch damaged on disk
inline bool same_square(const store::Square& a, const store::Square& b) {
    return std::memcmp(&a.counts(), &b.counts(), sizeof(store::PointCounts)) == 0 &&
           std::equal(a.patches().begin(), a.patches().end(), b.patches().begin(),
                      b.patches().end(), [&](const auto& p, const auto& q) {
                          return p.key == q.key && same_points(a.points(p.key), b.points(p.key));
                      });
}

inline store::ChunkIndex made_index(unsigned seed, std::size_t chunks) {
    std::mt19937 random(seed);
    std::vector<store::ChunkIndex::Chunk> out;
    std::uint64_t at = 0;
    for (std::size_t i = 0; i < chunks; ++i) {
        store::ChunkIndex::Chunk chunk;
        chunk.points.begin = at;
        chunk.points.end = at += 1 + random() % 100'000;
        for (unsigned p = random() % 20; p > 0; --p)
            chunk.patches.push_back(
                {static_cast<std::int32_t>(random() % 100) - 50, static_cast<std::int32_t>(p)});
        std::sort(chunk.patches.begin(), chunk.patches.end());
        out.push_back(std::move(chunk));
    }
    return store::ChunkIndex(std::move(out));
}

inline bool same_index(const store::ChunkIndex& a, const store::ChunkIndex& b) {
    return std::equal(a.chunks().begin(), a.chunks().end(), b.chunks().begin(), b.chunks().end(),
                      [](const auto& p, const auto& q) {
                          return p.points.begin == q.points.begin && p.points.end == q.points.end &&
                                 p.patches == q.patches;
                      });
}

/// As another program would: in a new file, so that what is mapped stays as it is.
inline void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
    std::filesystem::remove(file);
    std::ofstream(file, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// The files of a folder that end so; all bytes of them.
inline std::vector<std::filesystem::path> files_ending(const std::filesystem::path& folder,
                                                       const std::string& extension) {
    std::vector<std::filesystem::path> out;
    if (!std::filesystem::exists(folder))
        return out;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == extension)
            out.push_back(entry.path());
    std::sort(out.begin(), out.end());
    return out;
}
inline std::uint64_t bytes_in(const std::filesystem::path& folder) {
    std::uint64_t sum = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        sum += entry.file_size();
    return sum;
}

}  // namespace terravox::test
