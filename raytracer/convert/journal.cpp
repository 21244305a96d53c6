#include "raytracer/convert/journal.hpp"

#include <charconv>

#include "common/util/error.hpp"

namespace terravox::convert {

Journal::Journal(std::filesystem::path file, const std::string& what) : m_path(std::move(file)) {
    bool goes_on = false;
    if (std::ifstream in(m_path); in) {
        std::string line;
        goes_on = std::getline(in, line) && line == what;
        while (goes_on && std::getline(in, line)) {
            // "VOXELS NAME"; a line that was cut off ends in no dot.
            const auto blank = line.find(' ');
            std::uint64_t voxels = 0;
            if (line.size() < 2 || line.back() != '.' || blank == std::string::npos || std::from_chars(line.data(), line.data() + blank, voxels).ec != std::errc{}) continue;
            m_names.insert(line.substr(blank + 1, line.size() - blank - 2));
            m_voxels_before += voxels, ++m_files_before;
        }
    }
    m_out.open(m_path, goes_on ? std::ios::app : std::ios::trunc);
    // A line break first: the last line may have been cut off.
    m_out << (goes_on ? "" : what) << '\n' << std::flush;
    if (!m_out) throw Error("write the journal " + m_path.string() + ": cannot be written");
}

bool Journal::has(const std::string& name) const {
    const std::lock_guard lock(m_mutex);
    return m_names.contains(name);
}

void Journal::add(const std::string& name, std::uint64_t voxels) {
    const std::lock_guard lock(m_mutex);
    m_names.insert(name);
    m_out << voxels << ' ' << name << ".\n" << std::flush;
    if (!m_out) throw Error("write the journal " + m_path.string() + ": disk full, or cannot be written");
}

void Journal::remove() {
    const std::lock_guard lock(m_mutex);
    m_out.close();
    std::error_code ignored;
    std::filesystem::remove(m_path, ignored);
}

}  // namespace terravox::convert
