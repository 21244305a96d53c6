#include "voxelserver/export/core/journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sstream>

#include "common/util/error.hpp"

namespace terravox::exports {

Journal::Journal(std::filesystem::path file, const std::string& what)
    : m_path(std::move(file)), m_what(what) {
    lock();
    bool goes_on = false;
    if (std::ifstream in(m_path); in) {
        std::string line;
        goes_on = std::getline(in, line) && line == what;
        while (goes_on && std::getline(in, line)) {
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
    }
    open(goes_on);
}

Journal::~Journal() {
    if (m_lock >= 0)
        ::close(m_lock);
}

void Journal::lock() {
    m_lock = ::open(m_path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (m_lock < 0)
        throw util::Error("write the journal " + m_path.string() + ": " + std::strerror(errno));
    if (::flock(m_lock, LOCK_EX | LOCK_NB) == 0)
        return;
    ::close(m_lock);
    throw util::Error("write the journal " + m_path.string() +
                      ": another conversion is writing there");
}

void Journal::open(bool goes_on) {
    m_out.open(m_path, goes_on ? std::ios::app : std::ios::trunc);
    // A line break first: the last line may be incomplete.
    m_out << (goes_on ? "" : m_what) << '\n' << std::flush;
    if (!m_out)
        throw util::Error("write the journal " + m_path.string() + ": cannot be written");
}

bool Journal::has(const std::string& name) const {
    const std::lock_guard lock(m_mutex);
    return m_names.contains(name);
}

void Journal::add(const std::string& name, std::uint64_t voxels, std::uint64_t end) {
    const std::lock_guard lock(m_mutex);
    m_names.insert(name);
    m_out << voxels << ' ' << end << ' ' << name << " ;\n" << std::flush;
    if (!m_out)
        throw util::Error("write the journal " + m_path.string() +
                          ": disk full, or cannot be written");
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
    m_out.close();
    open(false);
}

void Journal::remove() {
    const std::lock_guard lock(m_mutex);
    m_out.close();
    std::error_code ignored;
    std::filesystem::remove(m_path, ignored);
}

}  // namespace terravox::exports
