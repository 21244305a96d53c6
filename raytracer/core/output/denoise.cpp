#include "raytracer/core/output/denoise.hpp"

#include <dlfcn.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <vector>

#include "common/util/error.hpp"

namespace terravox::output {
namespace {

namespace fs = std::filesystem;

constexpr const char* kName = "libOpenImageDenoise.so";

bool starts_with(const fs::path& file, const char* name) {
    return file.filename().string().starts_with(name);
}

/// Files of a folder whose names begin with the prefix, the last name first: the newest version.
std::vector<fs::path> files_in(const fs::path& folder, const char* name) {
    std::vector<fs::path> out;
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
        if (starts_with(it->path(), name) && !fs::is_directory(it->path(), error))
            out.push_back(it->path());
    std::sort(out.rbegin(), out.rend());
    return out;
}

std::vector<fs::path> list_candidates(const fs::path& given) {
    std::error_code error;
    if (!fs::is_directory(given, error))
        return {given};
    std::vector<fs::path> out;
    // As the project's own archives have it, and the packages `pyoidn` (version 2) and `oidn`
    // (version 1.4) of Python.
    for (const char* folder :
         {"", "lib", "lib64", "pyoidn/oidn/lib", "oidn/lib", "oidn/lib.linux.x64", "lib.linux.x64"})
        for (fs::path& file : files_in(given / folder, kName))
            out.push_back(std::move(file));
    return out;
}

/// Loads a library and the ones next to it that it needs: the packages contain a TBB that the
/// loader does not search for there.
void* open_file(const fs::path& file) {
    if (void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL))
        return library;
    for (const fs::path& tbb : files_in(file.parent_path(), "libtbb.so"))
        (void)dlopen(tbb.c_str(), RTLD_NOW | RTLD_GLOBAL);
    return dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
}

void* open_library(std::string& found) {
    if (const char* given = std::getenv("TERRAVOX_OIDN"); given != nullptr && *given != '\0') {
        std::string why = "no " + std::string(kName) + " there";
        for (const fs::path& file : list_candidates(given)) {
            found = file.string();
            if (void* library = open_file(file))
                return library;
            if (const char* said = dlerror())
                why = said;
        }
        throw util::UsageError("denoise the picture: TERRAVOX_OIDN = '" + std::string(given) +
                               "': " + why);
    }
    for (const char* version : {".2", ".1", ""}) {
        found = std::string(kName) + version;
        if (void* library = dlopen(found.c_str(), RTLD_NOW | RTLD_LOCAL))
            return library;
    }
    throw util::UsageError(
        "denoise the picture: Intel Open Image Denoise is not here; install the system's package "
        "of it, "
        "or `pip install --require-hashes --no-deps --target FOLDER -r "
        "config/setup/python/oidn.txt` "
        "and set TERRAVOX_OIDN=FOLDER; or leave out --denoise");
}

OidnLibrary load() {
    OidnLibrary out;
    void* library = open_library(out.file);
    const auto find = [&]<class Function>(Function& function, const char* name, const char* older) {
        void* symbol = dlsym(library, name);
        if (symbol == nullptr && older != nullptr)
            symbol = dlsym(library, older);
        if (symbol == nullptr)
            throw util::Error("denoise the picture: " + out.file + " has no function " + name);
        function = reinterpret_cast<Function>(symbol);
    };
    find(out.new_device, "oidnNewDevice", nullptr);
    find(out.commit_device, "oidnCommitDevice", nullptr);
    find(out.release_device, "oidnReleaseDevice", nullptr);
    find(out.device_error, "oidnGetDeviceError", nullptr);
    find(out.set_device_int, "oidnSetDeviceInt", "oidnSetDevice1i");
    find(out.set_device_bool, "oidnSetDeviceBool", "oidnSetDevice1b");
    find(out.new_filter, "oidnNewFilter", nullptr);
    find(out.release_filter, "oidnReleaseFilter", nullptr);
    find(out.set_image, "oidnSetSharedFilterImage", nullptr);
    find(out.set_filter_bool, "oidnSetFilterBool", "oidnSetFilter1b");
    find(out.commit_filter, "oidnCommitFilter", nullptr);
    find(out.execute_filter, "oidnExecuteFilter", nullptr);
    return out;
}

}  // namespace

const OidnLibrary& OidnLibrary::get() {
    static const OidnLibrary library = load();  // retried if it throws
    return library;
}

namespace {

using Handle = std::unique_ptr<void, void (*)(void*)>;

void check(const OidnLibrary& oidn, void* device) {
    const char* message = nullptr;
    if (oidn.device_error(device, &message) != 0)
        throw util::Error("denoise the picture with " + oidn.file + ": " +
                          (message != nullptr ? message : "it failed and did not say why"));
}

float finite(float v) noexcept {
    return std::isfinite(v) ? v : 0;
}

}  // namespace

void check_can_denoise() {
    (void)OidnLibrary::get();
}

void denoise(Film& film, int threads) {
    if (!film.has_layers())
        throw util::Error("denoise the picture: it has no layers to be guided by");
    const OidnLibrary& oidn = OidnLibrary::get();
    const auto width = static_cast<std::size_t>(film.width_px());
    const auto height = static_cast<std::size_t>(film.height_px());
    std::vector<voxel::Colour> colour;
    std::vector<voxel::Colour> albedo;
    std::vector<voxel::Colour> normal;
    for (auto* plane : {&colour, &albedo, &normal})
        plane->reserve(width * height);
    for (int y = 0; y < film.height_px(); ++y)
        for (int x = 0; x < film.width_px(); ++x) {
            const voxel::Colour& c = film.at(x, y).colour;
            const tiles::LayerSample& l = film.layers_at(x, y);
            colour.push_back({finite(c.r), finite(c.g), finite(c.b)});
            albedo.push_back({std::clamp(l.albedo.r, 0.0f, 1.0f),
                              std::clamp(l.albedo.g, 0.0f, 1.0f),
                              std::clamp(l.albedo.b, 0.0f, 1.0f)});
            normal.push_back({l.normal[0], l.normal[1], l.normal[2]});
        }

    const Handle device(oidn.new_device(OidnLibrary::kCpuDevice), oidn.release_device);
    if (!device)
        throw util::Error("denoise the picture with " + oidn.file +
                          ": it has no way to work on this CPU");
    oidn.set_device_int(device.get(), "numThreads", threads);
    // Other threads of this process must not be crowded out.
    oidn.set_device_bool(device.get(), "setAffinity", false);
    oidn.commit_device(device.get());
    check(oidn, device.get());
    const Handle filter(oidn.new_filter(device.get(), "RT"), oidn.release_filter);
    check(oidn, device.get());
    const auto image = [&](const char* name, std::vector<voxel::Colour>& plane) {
        static_assert(sizeof(voxel::Colour) == 3 * sizeof(float));
        oidn.set_image(filter.get(), name, plane.data(), OidnLibrary::kFloat3, width, height, 0, 0,
                       0);
    };
    image("color", colour);
    image("albedo", albedo);
    image("normal", normal);
    image("output", colour);
    oidn.set_filter_bool(filter.get(), "hdr", true);
    oidn.commit_filter(filter.get());
    oidn.execute_filter(filter.get());
    check(oidn, device.get());
    std::size_t next = 0;
    for (int y = 0; y < film.height_px(); ++y)
        for (int x = 0; x < film.width_px(); ++x)
            film.set_colour(x, y, colour[next++]);
}

}  // namespace terravox::output
