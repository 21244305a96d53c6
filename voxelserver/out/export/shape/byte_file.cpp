#include "voxelserver/out/export/shape/byte_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"

namespace terravox::exports {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 18;

}  // namespace

ByteFile::ByteFile(std::FILE* file, std::string named)
    : m_named(std::move(named)), m_buffer(kBufferBytes), m_file(file) {
    if (!m_file)
        fail();
    std::setvbuf(m_file.get(), m_buffer.data(), _IOFBF, m_buffer.size());
}

ByteFile::ByteFile(const std::filesystem::path& path, std::string named)
    : ByteFile(std::fopen(path.c_str(), "w+be"), std::move(named)) {}

ByteFile ByteFile::spool_for(const std::filesystem::path& target) {
    util::check_writable(target);
    const std::string named = target.string() + " (the data spooled next to it)";
    return {::fdopen(util::open_unnamed(target, "write " + named), "w+b"), named};
}

void ByteFile::fail() const {
    throw util::Error("write " + m_named + ": " + std::strerror(errno));
}

void ByteFile::put(std::span<const std::byte> bytes) {
    if (!bytes.empty() && std::fwrite(bytes.data(), 1, bytes.size(), m_file.get()) != bytes.size())
        fail();
    m_bytes += bytes.size();
}

void ByteFile::read(std::uint64_t offset, std::span<std::byte> out) {
    // A seek flushes the buffer, and a failure (disk full) is reported here.
    if (::fseeko(m_file.get(), static_cast<off_t>(offset), SEEK_SET) != 0)
        fail();
    errno = EIO;
    if (!out.empty() && std::fread(out.data(), 1, out.size(), m_file.get()) != out.size())
        fail();
}

void ByteFile::copy_to(ByteFile& to) {
    std::vector<std::byte> piece(kBufferBytes);
    for (std::uint64_t at = 0; at < m_bytes; at += piece.size()) {
        const auto part = std::span(piece).first(
            static_cast<std::size_t>(std::min<std::uint64_t>(piece.size(), m_bytes - at)));
        read(at, part);
        to.put(part);
    }
}

void ByteFile::close() {
    if (std::fclose(m_file.release()) != 0)
        fail();
}

}  // namespace terravox::exports
