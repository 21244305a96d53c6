#include "raytracer/core/output/picture_file.hpp"

#include <dlfcn.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cstdint>
#include <fstream>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/text.hpp"
#include "common/util/version.hpp"

namespace terravox::output {
namespace {

constexpr const char* kWhat = "module of pictures";

/// The module brings some hundred libraries. One of them starts threads as it is loaded, and waits
/// for ever where they get no memory, so room is looked for first.
/// @throws Error where the limit of this process leaves too little
void check_address_space() {
    constexpr std::size_t kMiB = 320;
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
        return;
    void* const room =
        mmap(nullptr, kMiB << 20, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (room == MAP_FAILED)
        throw util::Error(
            "load the {}: of the {} MiB of addresses that this process may have, less than {} are "
            "left; allowed: a higher limit (ulimit -v), or a .png",
            kWhat, limit.rlim_cur >> 20, kMiB);
    munmap(room, kMiB << 20);
}

const PictureModule& load_pictures() {
    check_address_space();
    void* const module = util::open_module(TERRAVOX_PICTURE_MODULE, kWhat);
    auto* const find = reinterpret_cast<FindPictureModule*>(dlsym(module, kFindPictureModule));
    if (find == nullptr)
        throw util::Error("load the " + std::string(kWhat) + " " +
                          util::module_file(TERRAVOX_PICTURE_MODULE).string() + ": it has no " +
                          kFindPictureModule);
    return find(kVersion);
}

const PictureModule& picture_module() {
    static const PictureModule& module = load_pictures();  // again when it throws
    return module;
}

/// Replaces a text in the header of a finished EXR file by another of the same length. Ref:
/// "OpenEXR File Layout": an attribute is name, 0, type, 0, size (4 bytes), value. No text has a 0
/// in it (with_clean_texts), so none looks like an attribute.
/// @throws Error when there is no such text
void replace_text(const std::filesystem::path& file, const std::string& name,
                  const std::string& value, const std::string& attempt) {
    constexpr std::size_t kMaxHeader = std::size_t{1} << 24;
    const std::string before = name + '\0' + "string" + '\0';
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    std::string header(kMaxHeader, '\0');
    stream.read(header.data(), kMaxHeader);
    stream.clear();
    if (const std::size_t at = header.find(before); at != std::string::npos) {
        stream.seekp(static_cast<std::streamoff>(at + before.size() + sizeof(std::uint32_t)));
        stream.write(value.data(), static_cast<std::streamsize>(value.size()));
        stream.flush();
        if (stream)
            return;
    }
    throw util::Error(attempt + ": " + name + " in its header cannot be brought up to date");
}

}  // namespace

PictureFile::PictureFile(const std::filesystem::path& file, const FileShape& shape,
                         const PictureInfo& info)
    : m_attempt("write the picture " + file.string()),
      m_target(file),
      m_encoder(picture_module().encode(m_target.temporary_path(), util::lower_extension(file),
                                        shape, info, m_attempt)) {}

void PictureFile::finish(const ImageMetadata& late_texts) {
    m_encoder->finish();
    for (const auto& [name, value] : late_texts)
        replace_text(m_target.temporary_path(), name, value, m_attempt);
    m_target.commit();
}

bool can_encode(const std::string& ending) {
    return picture_module().can_encode(ending);
}

}  // namespace terravox::output
