#include "voxelserver/make/worlds/minecraft/disk_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "common/util/error.hpp"

namespace terravox::minecraft {

DiskFile::DiskFile(const std::filesystem::path& path)
    : m_descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC)), m_name(path.string()) {
    measure();
}

DiskFile::DiskFile(int descriptor, std::string name)
    : m_descriptor(descriptor), m_name(std::move(name)) {
    measure();
}

DiskFile::~DiskFile() {
    if (m_descriptor >= 0)
        ::close(m_descriptor);
}

void DiskFile::measure() {
    struct stat status{};
    if (m_descriptor >= 0 && ::fstat(m_descriptor, &status) == 0) {
        m_size = static_cast<std::uint64_t>(status.st_size);
        return;
    }
    const int failure = errno;
    if (m_descriptor >= 0)
        ::close(m_descriptor);
    throw util::Error("open " + m_name + ": " + std::strerror(failure));
}

void DiskFile::read(std::uint64_t offset, std::span<std::uint8_t> out) const {
    while (!out.empty()) {
        const ssize_t got =
            ::pread(m_descriptor, out.data(), out.size(), static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            throw util::Error("read " + m_name + ": " + std::strerror(errno));
        if (got == 0)
            throw util::Error("read " + m_name + ": it ends at byte " + std::to_string(offset));
        offset += static_cast<std::uint64_t>(got);
        out = out.subspan(static_cast<std::size_t>(got));
    }
}

}  // namespace terravox::minecraft
