#include "raytracer/core/animate/frame_ledger.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <span>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/write_all.hpp"

namespace terravox::animate {
namespace {

/// Appends text in one piece, and has it on the disk on return. Machines that share a folder append
/// one after the other: over NFS, O_APPEND alone may lose one of two simultaneous lines; the lock
/// also refreshes the file's length.
void append(const std::filesystem::path& file, const std::string& text, int frame) {
    const auto fail = [&](const char* what) {
        throw util::Error("note that frame " + std::to_string(frame) + " is done: " +
                          file.string() + " cannot be " + what + ": " + std::strerror(errno));
    };
    struct Descriptor {
        int fd;
        ~Descriptor() {
            if (fd >= 0)
                ::close(fd);
        }
    };
    const Descriptor out{util::open_to_write(file, O_WRONLY | O_CREAT | O_APPEND, 0666,
                                             "note that frame " + std::to_string(frame) +
                                                 " is done: " + file.string() +
                                                 " cannot be written")};
    while (::flock(out.fd, LOCK_EX) != 0) {
        if (errno == ENOSYS || errno == EOPNOTSUPP || errno == ENOLCK || errno == EINVAL)
            break;  // a file system without locks
        if (errno != EINTR)
            fail("locked");
    }
    errno = util::write_all(out.fd, std::as_bytes(std::span(text)));
    if (errno != 0)
        fail("written");
    if (::fsync(out.fd) != 0 && errno != EINVAL && errno != ENOTSUP)
        fail("written");
}

}  // namespace

FrameLedger::FrameLedger(std::filesystem::path file) : m_file(std::move(file)) {
    constexpr std::uintmax_t kMax_bytes = 64U << 20;  // far more than any animation needs
    std::error_code failed;
    if (!std::filesystem::exists(m_file, failed))
        return;
    if (!std::filesystem::is_regular_file(m_file, failed) ||
        std::filesystem::file_size(m_file, failed) > kMax_bytes)
        throw util::Error("go on with the frames: " + m_file.string() +
                          " is no list of frames; remove it to make all anew");
    std::ifstream in(m_file);
    if (!in)
        throw util::Error("go on with the frames: " + m_file.string() + " cannot be read");
    for (std::string line; std::getline(in, line);) {
        int frame = 0;
        std::uint64_t fingerprint = 0;
        const char* end = line.data() + line.size();
        const auto number = std::from_chars(line.data(), end, frame);
        if (number.ec != std::errc{} || number.ptr == end || *number.ptr != ' ')
            continue;
        const auto print = std::from_chars(number.ptr + 1, end, fingerprint, 16);
        // All 16 digits are required: a line that was cut off has fewer.
        if (print.ec == std::errc{} && print.ptr == end && print.ptr - number.ptr == 17)
            m_done[frame] = fingerprint;
    }
}

bool FrameLedger::is_done(int frame, std::uint64_t fingerprint) const {
    const auto found = m_done.find(frame);
    return found != m_done.end() && found->second == fingerprint;
}

void FrameLedger::add(int frame, std::uint64_t fingerprint) {
    std::string digits(16, '0');
    for (std::size_t i = 0; i < 16; ++i)
        digits[15 - i] = "0123456789abcdef"[fingerprint >> (4 * i) & 15];
    std::error_code ignored;
    if (!m_file.parent_path().empty())
        std::filesystem::create_directories(m_file.parent_path(), ignored);
    // Starts a new line, whatever an interrupted run has left.
    append(m_file, "\n" + std::to_string(frame) + " " + digits + "\n", frame);
    m_done[frame] = fingerprint;
}

std::uint64_t fingerprint_of(const std::string& text) noexcept {
    std::uint64_t out = 0xcbf29ce484222325U;
    for (const char c : text)
        out = (out ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
    return out;
}

}  // namespace terravox::animate
