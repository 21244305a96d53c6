#include "voxelserver/data/pointcloud/file_bytes.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>

#include "common/util/error.hpp"

namespace terravox::pointcloud {

static_assert(std::endian::native == std::endian::little,
              "numbers of LAS files are mapped as they are");

FileBytes::FileBytes(std::filesystem::path path) : m_path(std::move(path)) {
    std::error_code failed;
    if (!std::filesystem::exists(m_path, failed))
        fail("no such file");
    if (!std::filesystem::is_regular_file(m_path, failed))
        fail("not a regular file");
    m_size = std::filesystem::file_size(m_path, failed);
    if (failed)
        fail(failed.message());
    m_file = util::Descriptor(::open(m_path.c_str(), O_RDONLY | O_CLOEXEC));
    if (m_file.get() < 0)
        fail(std::string("cannot be opened for reading: ") + std::strerror(errno));
}

void FileBytes::read(std::uint64_t offset, std::span<unsigned char> out) const {
    if (offset > m_size || out.size() > m_size - offset)
        fail("cut short: " + std::to_string(m_size) + " bytes, but " + std::to_string(out.size()) +
             " are expected at byte " + std::to_string(offset));
    for (std::size_t done = 0; done < out.size();) {
        const ssize_t n = ::pread(m_file.get(), out.data() + done, out.size() - done,
                                  static_cast<off_t>(offset + done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            fail("read error at byte " + std::to_string(offset + done) + ": " +
                 (n < 0 ? std::strerror(errno) : "the file became shorter"));
        done += static_cast<std::size_t>(n);
    }
}

void FileBytes::fail(const std::string& what) const {
    throw util::Error("read the point cloud {}: {}", m_path.string(), what);
}

}  // namespace terravox::pointcloud
