#pragma once

#include <terravox/error.hpp>

#include <filesystem>
#include <utility>

#include "common/util/error.hpp"
#include "raytracer/library/process_check.hpp"

namespace terravox {

/// Calls work() where the library can be used (process_check.hpp), and turns the errors of this
/// project into those that its users know.
template <class Work>
decltype(auto) guarded(Work&& work) {
    try {
        check_process();
        return std::forward<Work>(work)();
    } catch (const util::UsageError& e) {
        throw UsageError(e.what());
    } catch (const util::Error& e) {
        throw Error(e.what());
    } catch (const std::filesystem::filesystem_error& e) {
        throw Error(e.what());
    }
}

}  // namespace terravox
