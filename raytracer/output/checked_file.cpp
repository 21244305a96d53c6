#include "raytracer/output/checked_file.hpp"

#include <cerrno>
#include <cstring>
#include <utility>

#include "common/util/error.hpp"

namespace terravox::output {
namespace {

[[noreturn]] void fail(const std::string& attempt, int reason) {
    throw util::Error(attempt + ": " + std::strerror(reason));
}

std::FILE* open(const std::filesystem::path& path, const std::string& attempt) {
    std::FILE* file = std::fopen(path.c_str(), "wbe");
    if (file == nullptr)
        fail(attempt, errno);
    return file;
}

}  // namespace

CheckedFile::CheckedFile(const std::filesystem::path& path, std::string attempt)
    : m_attempt(std::move(attempt)),
      m_file(open(path, m_attempt)),
      m_proxy(m_file.get(), OIIO::Filesystem::IOProxy::Write) {}

void CheckedFile::attach_to(OIIO::ImageSpec& spec) {
    spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &m_pointer);
}

void CheckedFile::close() {
    errno = 0;
    const bool failed_before = std::ferror(m_file.get()) != 0;
    const bool closed = std::fclose(m_file.release()) == 0;
    if (failed_before || !closed)
        fail(m_attempt, errno != 0 ? errno : EIO);
}

}  // namespace terravox::output
