#include "common/voxel/archive/byte_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <optional>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel::archive {
namespace {

[[noreturn]] void fail_to_open(const std::filesystem::path& path, const std::string& what) {
    throw util::Error("open the box archive {}: {}", path.string(), what);
}

/// @return nullopt for what is not a plain file
std::optional<FileState> find_state(const struct stat& facts) {
    if (!S_ISREG(facts.st_mode))
        return std::nullopt;
    return FileState{static_cast<std::uint64_t>(facts.st_size), facts.st_mtim.tv_sec,
                     facts.st_mtim.tv_nsec, facts.st_dev, facts.st_ino};
}

std::string reason(int code) {
    return code == ENOENT || code == ENOTDIR ? "no such file" : std::strerror(code);
}

/// A file that is read and never mapped: when another program truncates a mapped file, accessing
/// the lost pages ends the program (SIGBUS), and mapped bytes may change between the verification
/// of a checksum and their use. Neither can happen to the copy in `room`.
class FileSource final : public ByteSource {
public:
    /// @param expected nullptr: any
    FileSource(const std::filesystem::path& path, const FileState* expected)
        : m_name(path.string()),
          // A pipe would block until it has a writer.
          m_file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
        if (m_file.get() < 0)
            fail_to_open(path, reason(errno));
        const std::optional<FileState> state = state_now();
        if (!state)
            fail_to_open(path, "not a plain file");
        m_state = *state;
        if (expected != nullptr && m_state != *expected)
            throw changed("another one was put in its place meanwhile");
    }

    [[nodiscard]] const std::string& name() const noexcept override { return m_name; }

    [[nodiscard]] std::span<const std::byte> read(std::uint64_t offset, std::size_t bytes,
                                                  std::vector<std::byte>& room) override {
        const std::uint64_t size = m_state.bytes;
        if (offset > size || bytes > size - offset)
            throw fail("bytes " + std::to_string(offset) + " to " + std::to_string(offset + bytes) +
                       "; the file has " + std::to_string(size));
        room.resize(bytes);
        for (std::size_t done = 0; done < bytes;) {
            const ssize_t n = ::pread(m_file.get(), room.data() + done, bytes - done,
                                      static_cast<off_t>(offset + done));
            if (n < 0 && errno == EINTR)
                continue;
            if (n < 0)
                throw fail(std::strerror(errno));
            if (n == 0)
                throw changed("it was cut short while it was open");
            done += static_cast<std::size_t>(n);
        }
        // Checked after reading the bytes: the time stamp of a write changes before its bytes can
        // be read. Index and boxes of two archives must not be mixed, since each of them may be
        // valid by itself.
        if (state_now() != m_state)
            throw changed(
                "it was changed while it was open; replace an archive by renaming another one to "
                "its name");
        return room;
    }

private:
    [[nodiscard]] util::Error fail(const std::string& what) const {
        return util::Error("read the box archive {}: {}", m_name, what);
    }
    [[nodiscard]] ChangedError changed(const std::string& what) const {
        return ChangedError(fail(what).what());
    }
    /// @return nullopt for what is not a plain file
    [[nodiscard]] std::optional<FileState> state_now() const {
        struct stat facts{};
        return ::fstat(m_file.get(), &facts) == 0 ? find_state(facts) : std::nullopt;
    }

    const std::string m_name;
    const util::Descriptor m_file;
    FileState m_state;
};

}  // namespace

std::unique_ptr<ByteSource> file_source(const std::filesystem::path& path) {
    return std::make_unique<FileSource>(path, nullptr);
}

std::unique_ptr<ByteSource> file_source(const std::filesystem::path& path,
                                        const FileState& expected) {
    return std::make_unique<FileSource>(path, &expected);
}

FileState file_state(const std::filesystem::path& path) {
    struct stat facts{};
    if (::stat(path.c_str(), &facts) != 0)
        fail_to_open(path, reason(errno));
    const std::optional<FileState> state = find_state(facts);
    if (!state)
        fail_to_open(path, "not a plain file");
    return *state;
}

}  // namespace terravox::voxel::archive
