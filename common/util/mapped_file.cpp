#include "common/util/mapped_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>

#include "common/util/error.hpp"

namespace terravox::util {

std::shared_ptr<const MappedFile> MappedFile::open(const std::filesystem::path& path) {
    const auto fail = [&](const char* what) {
        return Error("map the file " + path.string() + ": " + what);
    };
    // Opening a pipe would block until it has a writer.
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) {
        if (errno == ENOENT || errno == ENOTDIR)
            return nullptr;
        throw fail(std::strerror(errno));
    }
    struct stat facts{};
    const bool known = ::fstat(file, &facts) == 0 && S_ISREG(facts.st_mode);
    const auto size = static_cast<std::size_t>(known ? facts.st_size : 0);
    void* data =
        known && size > 0 ? ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0) : nullptr;
    const int code = errno;
    ::close(file);
    if (!known)
        throw fail("not a plain file");
    if (data == MAP_FAILED)
        throw fail(std::strerror(code));
    return std::shared_ptr<const MappedFile>(
        new MappedFile(static_cast<const std::byte*>(data), size));
}

MappedFile::~MappedFile() {
    if (m_size > 0)
        ::munmap(const_cast<std::byte*>(m_data), m_size);
}

bool readable(std::span<const std::byte> part) noexcept {
    if (part.empty())
        return true;
#ifdef MADV_POPULATE_READ
    static const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    const auto begin = reinterpret_cast<std::uintptr_t>(part.data()) / page * page;
    const auto end = reinterpret_cast<std::uintptr_t>(part.data() + part.size());
    // The check uses the mapping itself, so that no file needs to stay open for it. Pages that were
    // read are kept, so an interrupted call makes progress when it is repeated.
    int rc = -1;
    do
        rc = ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_POPULATE_READ);
    while (rc != 0 && (errno == EINTR || errno == EAGAIN));
    return rc == 0 || (errno != EFAULT && errno != EHWPOISON);
#else
    return true;
#endif
}

}  // namespace terravox::util
