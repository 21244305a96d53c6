#include "common/voxel/archive/archive_writer.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <string>

#include "common/util/error.hpp"
#include "common/util/files.hpp"

namespace terravox::voxel::archive {
namespace {

/// Entries of a run that are read together: 256 KiB.
constexpr std::uint64_t kReadEntries = 8192;

bool is_before(const Entry& a, const Entry& b) {
    return before(a.key, b.key);
}

/// Reads one run of the file, from its first entry to its last.
class RunReader {
public:
    /// @param begin, end numbers of entries in the file; not empty
    RunReader(int fd, std::uint64_t begin, std::uint64_t end, const std::string& attempt)
        : m_fd(fd), m_next(begin), m_end(end), m_attempt(attempt) {
        read();
    }
    [[nodiscard]] const Entry& entry() const noexcept { return m_entries[m_at]; }
    /// @return false after the last one
    bool next() {
        if (++m_at < m_entries.size())
            return true;
        if (m_next == m_end)
            return false;
        read();
        return true;
    }

private:
    void read() {
        m_entries.resize(static_cast<std::size_t>(std::min(kReadEntries, m_end - m_next)));
        auto to = std::as_writable_bytes(std::span(m_entries));
        std::uint64_t at = m_next * sizeof(Entry);
        while (!to.empty()) {
            const ssize_t count = ::pread(m_fd, to.data(), to.size(), static_cast<off_t>(at));
            if (count < 0 && errno == EINTR)
                continue;
            if (count <= 0)
                throw util::Error("{}: its entries cannot be read back: {}", m_attempt,
                                  count < 0 ? std::strerror(errno) : "they are gone");
            to = to.subspan(static_cast<std::size_t>(count));
            at += static_cast<std::uint64_t>(count);
        }
        m_next += m_entries.size();
        m_at = 0;
    }

    int m_fd;
    std::uint64_t m_next;
    std::uint64_t m_end;
    std::string m_attempt;
    std::vector<Entry> m_entries;
    std::size_t m_at = 0;
};

}  // namespace

EntryRuns::~EntryRuns() {
    if (m_fd >= 0)
        ::close(m_fd);
}

std::string EntryRuns::attempt() const {
    return "write the index of " + m_near.string();
}

void EntryRuns::add(const Entry& entry) {
    if (m_run.size() == m_run_entries)
        spill();
    m_run.push_back(entry);
}

void EntryRuns::spill() {
    if (m_fd < 0)
        m_fd = util::open_unnamed(m_near, attempt());
    std::sort(m_run.begin(), m_run.end(), is_before);
    if (const int failed = util::write_all(m_fd, std::as_bytes(std::span(m_run))); failed != 0)
        throw util::Error(attempt() + ": " + std::strerror(failed));
    m_spilled += m_run.size();
    m_run.clear();
}

void EntryRuns::each_sorted(const std::function<void(const Entry&)>& visit) {
    if (m_spilled == 0) {
        std::sort(m_run.begin(), m_run.end(), is_before);
        std::for_each(m_run.begin(), m_run.end(), visit);
        return;
    }
    if (!m_run.empty())
        spill();
    std::vector<RunReader> readers;
    for (std::uint64_t begin = 0; begin < m_spilled; begin += m_run_entries)
        readers.emplace_back(m_fd, begin, std::min(begin + m_run_entries, m_spilled), attempt());
    // A heap: its first reader has the least entry.
    const auto is_later = [](const RunReader& a, const RunReader& b) {
        return is_before(b.entry(), a.entry());
    };
    std::make_heap(readers.begin(), readers.end(), is_later);
    while (!readers.empty()) {
        std::pop_heap(readers.begin(), readers.end(), is_later);
        visit(readers.back().entry());
        if (readers.back().next())
            std::push_heap(readers.begin(), readers.end(), is_later);
        else
            readers.pop_back();
    }
}

}  // namespace terravox::voxel::archive
