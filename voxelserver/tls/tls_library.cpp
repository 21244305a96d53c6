#include "voxelserver/tls/tls_library.hpp"

#include <dlfcn.h>

#include <filesystem>

#include "common/util/error.hpp"

namespace terravox::tls {

void load_library() {
    std::error_code ignored;
    const auto file = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path() / TERRAVOX_TLS_LIBRARY;
    // Kept open for the life of the process.
    if (dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL) == nullptr) {
        const char* why = dlerror();
        throw Error("load the TLS library " + file.string() + ": " + (why != nullptr ? why : "unknown error"));
    }
}

}  // namespace terravox::tls
