#include "raytracer/core/output/picture_file.hpp"

#include <dlfcn.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <istream>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/text.hpp"
#include "common/util/version.hpp"

namespace terravox::output {
namespace {

constexpr const char* kWhat = "module of pictures";

const PictureModule& load_pictures() {
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

/// The next string of a header, which ends with 0.
std::string next_string(std::istream& in) {
    std::string out;
    std::getline(in, out, '\0');
    return out;
}

/// A number of four bytes, the lowest first.
std::uint32_t next_number(std::istream& in) {
    std::array<unsigned char, 4> bytes{};
    in.read(reinterpret_cast<char*>(bytes.data()), bytes.size());
    std::uint32_t out = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
        out |= static_cast<std::uint32_t>(bytes[i]) << 8 * i;
    return out;
}

/// Goes to the value of a text in the header of a finished EXR file. Ref: "OpenEXR File Layout":
/// magic number and version (4 bytes each), then attributes, each of which is name, 0, type, 0,
/// size (4 bytes), value; an empty name ends them.
/// @return whether there is such a text, of that many bytes
bool go_to_text(std::iostream& file, const std::string& name, std::size_t bytes) {
    constexpr std::streamoff kFirstAttribute = 8;
    file.seekg(kFirstAttribute);
    while (file) {
        const std::string found = next_string(file);
        const std::string type = next_string(file);
        const std::uint32_t size = next_number(file);
        if (found.empty())
            return false;
        if (found == name) {
            file.seekp(file.tellg());
            return file && type == "string" && size == bytes;
        }
        file.seekg(size, std::ios::cur);
    }
    return false;
}

/// Replaces a text in the header of a finished EXR file by another of the same length.
/// @throws Error when there is no such text
void replace_text(const std::filesystem::path& file, const std::string& name,
                  const std::string& value, const std::string& attempt) {
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    if (go_to_text(stream, name, value.size())) {
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
