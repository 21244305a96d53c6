#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <new>
#include <type_traits>

#include "raytracer/shade/face_cell.hpp"

namespace terravox::shade {

/// A map from cells to values within a fixed number of bytes: a cell has a few places, chosen by
/// its hash, and a new one replaces another when they are full. Thread-safe: each group of places
/// has one of many locks.
template <class Value>
class CacheTable {
    static_assert(std::is_trivially_copyable_v<Value>);

public:
    /// @param limit_bytes at least one group of places is kept whatever the limit
    explicit CacheTable(std::size_t limit_bytes)
        : m_groups(std::clamp<std::size_t>(limit_bytes / sizeof(Group), 1, kMaxGroups)),
          // The system hands out zeroed pages when they are first touched.
          m_places(static_cast<Group*>(std::calloc(m_groups, sizeof(Group)))) {
        if (!m_places)
            throw std::bad_alloc();
    }

    [[nodiscard]] bool find(const FaceCell& key, Value& out) {
        const std::uint64_t hash = key.hash();
        const std::size_t at = group_of(hash);
        const std::lock_guard lock(m_locks[at % kLocks]);
        for (const Place& place : m_places.get()[at])
            if (place.key == key) {
                out = place.value;
                return true;
            }
        return false;
    }
    void insert(const FaceCell& key, const Value& value) {
        const std::uint64_t hash = key.hash();
        const std::size_t at = group_of(hash);
        const std::lock_guard lock(m_locks[at % kLocks]);
        Group& group = m_places.get()[at];
        Place* to = &group[hash % kWays];
        for (Place& place : group)
            if (!place.key.used() || place.key == key) {
                to = &place;
                break;
            }
        *to = {key, value};
    }

private:
    static constexpr std::size_t kWays = 4;
    static constexpr std::size_t kLocks = 1024;
    static constexpr std::size_t kMaxGroups = 0xffffffff;
    struct Place {
        FaceCell key;
        Value value;
    };
    using Group = std::array<Place, kWays>;
    struct Free {
        void operator()(Group* groups) const noexcept { std::free(groups); }
    };
    [[nodiscard]] std::size_t group_of(std::uint64_t hash) const noexcept {
        return static_cast<std::size_t>((hash >> 32) * m_groups >> 32);
    }

    std::size_t m_groups;
    std::unique_ptr<Group, Free> m_places;
    std::array<std::mutex, kLocks> m_locks;
};

}  // namespace terravox::shade
