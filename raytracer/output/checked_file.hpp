#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

namespace terravox::output {

/// A file that OpenImageIO writes to through this class. OpenEXR and OpenImageIO close the files
/// that they open themselves without checking the result: on a full disk, the last bytes of a
/// picture could be missing without an error. Not thread-safe.
class CheckedFile {
public:
    /// @param attempt begins the messages, such as "write the picture a.exr"
    /// @throws Error when the file cannot be opened for writing
    CheckedFile(const std::filesystem::path& path, std::string attempt);
    CheckedFile(const CheckedFile&) = delete;
    CheckedFile& operator=(const CheckedFile&) = delete;

    /// Makes an output that is opened with `spec` write here. The output must be closed before this
    /// object is destroyed.
    void attach_to(OIIO::ImageSpec& spec);
    /// To be called after the output was closed.
    /// @throws Error when not all bytes could be written, with the system's reason
    void close();

private:
    struct Close {
        void operator()(std::FILE* file) const noexcept { std::fclose(file); }
    };
    std::string m_attempt;
    std::unique_ptr<std::FILE, Close> m_file;
    OIIO::Filesystem::IOFile m_proxy;
    OIIO::Filesystem::IOProxy* m_pointer = &m_proxy;  ///< address that a spec refers to
};

}  // namespace terravox::output
