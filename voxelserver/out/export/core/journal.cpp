#include "voxelserver/out/export/core/journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <span>
#include <sstream>
#include <system_error>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/files.hpp"

namespace terravox::exports {

Journal::Journal(std::filesystem::path file, const std::string& what)
    : m_path(std::move(file)), m_what(what) {
    try {
        open();
        begin(read());
    } catch (...) {
        // No destructor runs, and the lock must end.
        close();
        throw;
    }
}

Journal::~Journal() {
    close();
}

void Journal::close() noexcept {
    if (m_fd >= 0)
        ::close(std::exchange(m_fd, -1));
}

void Journal::fail(const std::string& why) const {
    throw util::Error("write the journal " + m_path.string() + ": " + why);
}

// One that ends while another opens the file removes it: the other one then has a lock on a file
// without a name, and opens again.
void Journal::open() {
    do {
        close();
        m_fd = util::open_to_write(m_path, O_RDWR | O_CREAT | O_APPEND, 0644,
                                   "write the journal " + m_path.string());
        if (::flock(m_fd, LOCK_EX | LOCK_NB) != 0)
            fail("another conversion is writing there");
    } while (!util::is_named(m_fd, m_path));
}

bool Journal::read() {
    std::ifstream in(m_path);
    std::string line;
    if (!std::getline(in, line) || line != m_what)
        return false;
    while (std::getline(in, line)) {
        // "VOXELS END NAME ;": an incomplete line lacks the last.
        std::istringstream words(line);
        std::uint64_t voxels = 0;
        std::uint64_t end = 0;
        std::string name;
        std::string last;
        if (!(words >> voxels >> end >> name >> last) || last != ";" ||
            !m_names.insert(name).second)
            continue;
        m_voxels_before += voxels;
        ++m_files_before;
        m_end_before = std::max(m_end_before, end);
    }
    return true;
}

void Journal::begin(bool goes_on) {
    if (!goes_on && ::ftruncate(m_fd, 0) != 0)
        fail(std::strerror(errno));
    try {
        // A line break first: the last line may be incomplete.
        append((goes_on ? "" : m_what) + "\n");
    } catch (...) {
        // Without its first line a journal is of no use.
        if (!goes_on)
            ::unlink(m_path.c_str());
        throw;
    }
}

void Journal::append(const std::string& text) const {
    if (const int failed = util::write_all(m_fd, std::as_bytes(std::span(text))); failed != 0)
        fail(std::strerror(failed));
}

bool Journal::has(const std::string& name) const {
    const std::lock_guard lock(m_mutex);
    return m_names.contains(name);
}

void Journal::add(const std::string& name, std::uint64_t voxels, std::uint64_t end) {
    const std::lock_guard lock(m_mutex);
    m_names.insert(name);
    append(std::to_string(voxels) + ' ' + std::to_string(end) + ' ' + name + " ;\n");
}

std::size_t Journal::files_in(const std::filesystem::path& file, const std::string& what) {
    std::ifstream in(file);
    std::string line;
    if (!std::getline(in, line) || line != what)
        return 0;
    std::size_t count = 0;
    while (std::getline(in, line))
        count += line.ends_with(" ;") ? 1 : 0;
    return count;
}

void Journal::forget() {
    const std::lock_guard lock(m_mutex);
    m_names.clear();
    m_voxels_before = m_end_before = 0;
    m_files_before = 0;
    begin(false);
}

void Journal::remove() {
    const std::lock_guard lock(m_mutex);
    std::error_code ignored;
    std::filesystem::remove(m_path, ignored);
}

}  // namespace terravox::exports
