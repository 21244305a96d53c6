#include "common/voxel/archive/byte_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <optional>

#include "common/util/error.hpp"
#include "common/voxel/changed_error.hpp"

namespace terravox::voxel::archive {
namespace {

/// The properties that change when another program writes to an open file, or truncates it.
struct FileState {
    std::int64_t bytes = 0;
    std::int64_t changed_s = 0;
    std::int64_t changed_ns = 0;
    friend bool operator==(const FileState&, const FileState&) = default;
};

/// A file that is read and never mapped: when another program truncates a mapped file, accessing
/// the lost pages ends the program (SIGBUS), and mapped bytes may change between the verification
/// of a checksum and their use. Neither can happen to the copy in `room`.
class FileSource final : public ByteSource {
public:
    explicit FileSource(const std::filesystem::path& path)
        : m_name(path.string()),
          // A pipe would block until it has a writer.
          m_file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
        const auto fail = [&](const std::string& what) {
            return util::Error("open the box archive " + m_name + ": " + what);
        };
        if (m_file < 0)
            throw fail(errno == ENOENT || errno == ENOTDIR ? "no such file" : std::strerror(errno));
        try {
            const std::optional<FileState> state = state_now();
            if (!state)
                throw fail("not a plain file");
            m_state = *state;
        } catch (...) {
            ::close(m_file);
            throw;
        }
    }
    ~FileSource() override { ::close(m_file); }

    [[nodiscard]] const std::string& name() const noexcept override { return m_name; }

    [[nodiscard]] std::span<const std::byte> read(std::uint64_t offset, std::size_t bytes,
                                                  std::vector<std::byte>& room) override {
        const auto size = static_cast<std::uint64_t>(m_state.bytes);
        if (offset > size || bytes > size - offset)
            throw fail("bytes " + std::to_string(offset) + " to " + std::to_string(offset + bytes) +
                       "; the file has " + std::to_string(size));
        room.resize(bytes);
        for (std::size_t done = 0; done < bytes;) {
            const ssize_t n = ::pread(m_file, room.data() + done, bytes - done,
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
        return util::Error("read the box archive " + m_name + ": " + what);
    }
    [[nodiscard]] ChangedError changed(const std::string& what) const {
        return ChangedError(fail(what).what());
    }
    /// @return nullopt for what is not a plain file
    [[nodiscard]] std::optional<FileState> state_now() const {
        struct stat facts{};
        if (::fstat(m_file, &facts) != 0 || !S_ISREG(facts.st_mode))
            return std::nullopt;
        return FileState{facts.st_size, facts.st_mtim.tv_sec, facts.st_mtim.tv_nsec};
    }

    const std::string m_name;
    const int m_file;
    FileState m_state;
};

}  // namespace

std::unique_ptr<ByteSource> file_source(const std::filesystem::path& path) {
    return std::make_unique<FileSource>(path);
}

}  // namespace terravox::voxel::archive
