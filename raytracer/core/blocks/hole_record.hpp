#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <set>
#include <string>

#include "common/voxel/box.hpp"

namespace terravox::blocks {

/// The boxes that could not be made or fetched, and why. Each is counted once, and stays a hole
/// until it is forgotten. Not thread-safe: the block manager uses it under its lock.
class HoleRecord {
public:
    /// Records a hole and logs its reason, unless the same reason has been logged before. A box
    /// that failed with voxel::ChangedError is not logged; the first such error is kept.
    /// @param failure not null
    void add(const voxel::BoxKey& key, const std::exception_ptr& failure);
    [[nodiscard]] bool contains(const voxel::BoxKey& key) const { return m_holes.contains(key); }
    [[nodiscard]] std::size_t size() const noexcept { return m_holes.size(); }
    /// Forgets the holes for which may_forget(key) is true, and begins a new generation.
    void forget(const std::function<bool(const voxel::BoxKey&)>& may_forget);
    /// Number of calls of forget() so far.
    [[nodiscard]] std::uint64_t generation() const noexcept { return m_generation; }
    /// @throws voxel::ChangedError the first one that was added, also after forget()
    void check_world() const;

private:
    std::set<voxel::BoxKey> m_holes;
    std::set<std::string> m_reasons;  ///< those that were logged
    std::exception_ptr m_changed;     ///< the first ChangedError
    std::uint64_t m_generation = 0;
};

}  // namespace terravox::blocks
