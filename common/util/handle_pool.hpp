#pragma once

#include <cstddef>
#include <limits>
#include <mutex>
#include <utility>
#include <vector>

namespace terravox::util {

/// Handles of what is costly to open and serves one thread at a time: data sets, archives,
/// connections, readers with their scratch memory. Each caller borrows an idle one, the last used
/// first, or opens another. Thread-safe; must outlive its leases.
/// @tparam Handle a std::unique_ptr
template <class Handle>
class HandlePool {
public:
    /// A handle for one caller, given back at the end.
    class Lease {
    public:
        Lease(HandlePool& pool, Handle handle) : m_pool(pool), m_handle(std::move(handle)) {}
        ~Lease() {
            if (m_is_whole)
                m_pool.give_back(std::move(m_handle));
        }
        Lease(const Lease&) = delete;
        Lease& operator=(const Lease&) = delete;
        [[nodiscard]] auto get() const noexcept { return m_handle.get(); }
        [[nodiscard]] decltype(auto) operator*() const noexcept { return *m_handle; }
        [[nodiscard]] auto operator->() const noexcept { return m_handle.get(); }
        /// Has it closed at the end: what went wrong with it must not reach the next caller.
        void drop() noexcept { m_is_whole = false; }

    private:
        HandlePool& m_pool;
        Handle m_handle;
        bool m_is_whole = true;
    };

    /// @param max_idle handles that are kept while nobody uses them; others are closed
    explicit HandlePool(std::size_t max_idle = std::numeric_limits<std::size_t>::max())
        : m_max_idle(max_idle) {}

    /// @param open Handle(): called when none is idle, without a lock
    /// @throws what `open` throws
    template <class Open>
    [[nodiscard]] Lease borrow(const Open& open) {
        Handle idle = take();
        return Lease(*this, idle ? std::move(idle) : open());
    }

    /// Visits all idle handles, in unspecified order.
    template <class Visit>
    void for_each(const Visit& visit) {
        const std::lock_guard lock(m_mutex);
        for (const Handle& handle : m_idle)
            visit(*handle);
    }

private:
    Handle take() {
        const std::lock_guard lock(m_mutex);
        if (m_idle.empty())
            return {};
        Handle out = std::move(m_idle.back());
        m_idle.pop_back();
        return out;
    }
    void give_back(Handle handle) noexcept {
        try {
            const std::lock_guard lock(m_mutex);
            if (m_idle.size() < m_max_idle)
                m_idle.push_back(std::move(handle));
        } catch (...) {
            handle.reset();  // without memory it is closed, and opened again
        }
    }

    const std::size_t m_max_idle;
    std::mutex m_mutex;
    std::vector<Handle> m_idle;
};

}  // namespace terravox::util
