#include "common/util/beside_program.hpp"

#include <dlfcn.h>
#include <link.h>

#include <string>
#include <system_error>

#include "common/util/error.hpp"

namespace terravox::util {

std::filesystem::path own_file() {
    std::error_code ignored;
    Dl_info symbol{};
    void* object = nullptr;
    const auto* const here = reinterpret_cast<const void*>(&own_file);
    if (dladdr1(here, &symbol, &object, RTLD_DL_LINKMAP) != 0 && object != nullptr) {
        // The name of the program itself is empty here.
        const std::string name = static_cast<const link_map*>(object)->l_name;
        if (!name.empty())
            return std::filesystem::canonical(name, ignored);
    }
    return std::filesystem::read_symlink("/proc/self/exe", ignored);
}

std::filesystem::path beside_program(std::string_view name) {
    return own_file().parent_path() / name;
}

bool has_version(const std::filesystem::path& library) {
    return library.filename().string().find(".so.") != std::string::npos;
}

std::filesystem::path module_file(std::string_view name) {
    const std::filesystem::path own = own_file();
    if (has_version(own))
        return own.parent_path() / "terravox" / own.filename() / name;
    return own.parent_path() / name;
}

void* open_module(std::string_view name, std::string_view what) {
    const std::filesystem::path file = module_file(name);
    // Never closed: threads, exceptions and objects of the library may outlive the caller that
    // opened it.
    if (void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL))
        return library;
    const char* why = dlerror();
    throw Error("load the " + std::string(what) + " " + file.string() + ": " +
                (why != nullptr ? why : "unknown error"));
}

}  // namespace terravox::util
