#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>

namespace terravox::util {

struct CacheStats {
    std::uint64_t hits = 0;
    std::uint64_t misses = 0;
    std::uint64_t waits = 0;
    std::uint64_t evictions = 0;
    std::size_t bytes = 0;
    std::size_t entries = 0;
};

/// An LRU cache with a byte limit that makes each value once: threads that request a key while its
/// value is being made wait for that result.
///
/// Least recently used values are evicted first; a value larger than the limit is returned but not
/// kept. Values are shared: a value in use outlives its eviction, so evicting never hurts a reader.
/// nullptr is a value too (known to be empty). An exception of `make` is rethrown to every waiting
/// caller and is not cached. Thread-safe. One lock guards the maps and is never held while `make`
/// runs. `make` must not request the same key from this cache.
template <class Key, class Value, class Hash = std::hash<Key>>
class Cache {
public:
    using Ptr = std::shared_ptr<const Value>;

    explicit Cache(std::size_t limit_bytes) : m_limit_bytes(limit_bytes) {}

    /// @param make  Ptr(): called at most once at a time for a missing key
    /// @param measure_bytes std::size_t(const Ptr&): the size of the value
    template <class Make, class MeasureBytes>
    Ptr get(const Key& key, const Make& make, const MeasureBytes& measure_bytes) {
        std::shared_ptr<std::promise<Ptr>> promise;
        std::shared_future<Ptr> pending;
        {
            const std::lock_guard lock(m_mutex);
            if (const auto found = m_entries.find(key); found != m_entries.end()) {
                ++m_stats.hits;
                m_order.splice(m_order.begin(), m_order, found->second);
                return found->second->value;
            }
            if (const auto making = m_making.find(key); making != m_making.end()) {
                ++m_stats.waits;
                pending = making->second;
            } else {
                ++m_stats.misses;
                promise = std::make_shared<std::promise<Ptr>>();
                m_making.emplace(key, promise->get_future().share());
            }
        }
        if (pending.valid())
            return pending.get();
        try {
            Ptr value = make();
            {
                std::list<Entry> evicted;  // destroyed after the lock is released
                const std::lock_guard lock(m_mutex);
                m_making.erase(key);
                insert(key, value, measure_bytes(value), evicted);
            }
            promise->set_value(value);
            return value;
        } catch (...) {
            {
                const std::lock_guard lock(m_mutex);
                m_making.erase(key);
            }
            promise->set_exception(std::current_exception());
            throw;
        }
    }

    /// The value if it is cached: nothing is made, no thread waits, and no statistics count it.
    [[nodiscard]] Ptr find(const Key& key) {
        const std::lock_guard lock(m_mutex);
        return look(key);
    }

    /// Like find(), but counted as a hit when the value is cached, and not counted when it is not:
    /// for callers that call get() next.
    [[nodiscard]] Ptr hit(const Key& key) {
        const std::lock_guard lock(m_mutex);
        Ptr out = look(key);
        if (out)
            ++m_stats.hits;
        return out;
    }

    /// Whether the value is cached; does not affect the LRU order.
    [[nodiscard]] bool holds(const Key& key) const {
        const std::lock_guard lock(m_mutex);
        return m_entries.contains(key);
    }

    /// Adds a value that was made elsewhere. Does nothing when the key is cached or its value is
    /// being made.
    void put(const Key& key, const Ptr& value, std::size_t bytes) {
        std::list<Entry> evicted;
        const std::lock_guard lock(m_mutex);
        if (m_entries.contains(key) || m_making.contains(key))
            return;
        insert(key, value, bytes, evicted);
    }

    /// Removes every value whose key satisfies the predicate.
    template <class Fits>
    void erase_if(const Fits& fits) {
        std::list<Entry> erased;
        const std::lock_guard lock(m_mutex);
        for (auto it = m_order.begin(); it != m_order.end();) {
            const auto next = std::next(it);
            if (fits(it->key)) {
                m_bytes -= it->bytes;
                m_entries.erase(it->key);
                erased.splice(erased.begin(), m_order, it);
            }
            it = next;
        }
    }

    /// Calls back with every cached key, most recently used first, under the lock: the callback
    /// must be quick and must not access this cache.
    template <class Callback>
    void each_key(const Callback& callback) const {
        const std::lock_guard lock(m_mutex);
        for (const Entry& e : m_order)
            callback(e.key);
    }

    [[nodiscard]] CacheStats stats() const {
        const std::lock_guard lock(m_mutex);
        CacheStats out = m_stats;
        out.bytes = m_bytes;
        out.entries = m_entries.size();
        return out;
    }

    [[nodiscard]] std::size_t limit_bytes() const noexcept { return m_limit_bytes; }

private:
    struct Entry {
        Key key;
        Ptr value;
        std::size_t bytes;
    };
    static constexpr std::size_t kEntryBytes =
        sizeof(Entry) +
        6 * sizeof(void*);  // list node and map node, so that empty values count too

    // Requires the lock.
    Ptr look(const Key& key) {
        const auto found = m_entries.find(key);
        if (found == m_entries.end())
            return nullptr;
        m_order.splice(m_order.begin(), m_order, found->second);
        return found->second->value;
    }

    // Requires the lock. Evicted entries are moved to `evicted`, for the caller to destroy them
    // after releasing it.
    void insert(const Key& key, const Ptr& value, std::size_t bytes, std::list<Entry>& evicted) {
        m_order.push_front({key, value, bytes + kEntryBytes});
        m_entries.emplace(key, m_order.begin());
        m_bytes += bytes + kEntryBytes;
        while (m_bytes > m_limit_bytes) {
            const auto last = std::prev(m_order.end());
            m_bytes -= last->bytes;
            m_entries.erase(last->key);
            evicted.splice(evicted.begin(), m_order, last);
            ++m_stats.evictions;
        }
    }

    const std::size_t m_limit_bytes;
    mutable std::mutex m_mutex;
    std::list<Entry> m_order;  // most recently used first
    std::unordered_map<Key, typename std::list<Entry>::iterator, Hash> m_entries;
    std::unordered_map<Key, std::shared_future<Ptr>, Hash> m_making;
    std::size_t m_bytes = 0;
    CacheStats m_stats;
};

}  // namespace terravox::util
