#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "voxelserver/make/worlds/minecraft/chunk.hpp"
#include "voxelserver/make/worlds/minecraft/chunk_store.hpp"
#include "voxelserver/make/worlds/minecraft/voxel_chunk.hpp"

namespace terravox::minecraft {

/// Reads chunks of one store, one after the other, and checks that each is at its own place. Not
/// thread-safe: one for each thread.
class ChunkReader {
public:
    explicit ChunkReader(const ChunkStore& store) : m_store(store) {}
    /// @return valid until the next call
    /// @throws Error: why the chunk cannot be used
    const ChunkBlocks& read(const ChunkRef& chunk);
    /// Compression of the chunk that was read last.
    [[nodiscard]] Compression compression() const noexcept { return m_compression; }

private:
    const ChunkStore& m_store;
    ChunkStore::Reader m_reader;
    ChunkBlocks m_blocks;
    Compression m_compression = Compression::kNone;
};

/// Pool of objects that are used by one thread at a time: each thread takes an idle one, or makes
/// another. Thread-safe.
template <class Tool>
class Toolbox {
public:
    /// Calls work(tool).
    /// @param make std::unique_ptr<Tool>(): called when none is idle
    template <class Make, class Work>
    auto with(const Make& make, const Work& work) {
        std::unique_ptr<Tool> tool = take();
        if (tool == nullptr)
            tool = make();
        const PutBack put_back{*this, tool};
        return work(*tool);
    }

    /// Visits all idle tools, in unspecified order.
    template <class Visit>
    void for_each(const Visit& visit) {
        const std::lock_guard lock(m_mutex);
        for (const auto& tool : m_idle)
            visit(*tool);
    }

private:
    struct PutBack {
        Toolbox& box;
        std::unique_ptr<Tool>& tool;
        ~PutBack() {
            const std::lock_guard lock(box.m_mutex);
            box.m_idle.push_back(std::move(tool));
        }
    };
    std::unique_ptr<Tool> take() {
        const std::lock_guard lock(m_mutex);
        if (m_idle.empty())
            return nullptr;
        std::unique_ptr<Tool> out = std::move(m_idle.back());
        m_idle.pop_back();
        return out;
    }
    std::mutex m_mutex;
    std::vector<std::unique_ptr<Tool>> m_idle;
};

}  // namespace terravox::minecraft
