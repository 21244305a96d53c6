#pragma once

#include <cstddef>
#include <string>

#include "raytracer/core/output/picture.hpp"

namespace terravox::output {

/// The few functions of Intel Open Image Denoise (C interface of versions 1 and 2) that are needed,
/// loaded at run time on first use: the programs do not depend on the library. Ref: Open Image
/// Denoise documentation, "API".
struct OidnLibrary {
    enum : int { kCpuDevice = 1, kFloat3 = 3 };
    void* (*new_device)(int type) = nullptr;
    void (*commit_device)(void* device) = nullptr;
    void (*release_device)(void* device) = nullptr;
    int (*device_error)(void* device, const char** message) = nullptr;
    void (*set_device_int)(void* device, const char* name, int value) = nullptr;
    void (*set_device_bool)(void* device, const char* name, bool value) = nullptr;
    void* (*new_filter)(void* device, const char* type) = nullptr;
    void (*release_filter)(void* filter) = nullptr;
    void (*set_image)(void* filter, const char* name, void* first, int format, std::size_t width,
                      std::size_t height, std::size_t offset, std::size_t pixel_stride,
                      std::size_t row_stride) = nullptr;
    void (*set_filter_bool)(void* filter, const char* name, bool value) = nullptr;
    void (*commit_filter)(void* filter) = nullptr;
    void (*execute_filter)(void* filter) = nullptr;
    std::string file;  ///< path of the library

    /// Looks in $TERRAVOX_OIDN (the library, or a folder: itself, lib, or where Python's package
    /// `oidn` keeps it), then where the system's loader looks. Loaded once and never unloaded.
    /// @throws UsageError that explains how to install it; Error for a library that lacks a
    /// function
    static const OidnLibrary& get();
};

/// Checks that denoising is possible; to be called before any work is done.
/// @throws UsageError where Open Image Denoise cannot be loaded
void check_can_denoise();

/// Denoises the film's colours with Intel Open Image Denoise, guided by albedo and normals, which
/// must be present (the sharper they are, the more detail is kept). Alpha, depth and layers are not
/// changed. The result is the same in each run on a machine, but not to the last bit on CPUs with
/// other vector instructions: it is the only step of a picture with this property.
/// @param threads at least 1
/// @throws UsageError as above; Error when the film has no layers, or the library fails
void denoise(Film& film, int threads);

}  // namespace terravox::output
