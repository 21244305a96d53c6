#pragma once

#include <terravox/control.hpp>
#include <terravox/error.hpp>

#include <exception>
#include <new>
#include <utility>

#include "common/util/error.hpp"
#include "raytracer/apps/library/process_check.hpp"

namespace terravox {

/// Calls work() where the library can be used (process_check.hpp), and turns all errors but missing
/// memory into those that its users know.
template <class Work>
decltype(auto) guarded(Work&& work) {
    try {
        check_process();
        return std::forward<Work>(work)();
    } catch (const Error&) {
        throw;
    } catch (const util::UsageError& e) {
        throw UsageError(e.what());
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        throw Error(e.what());
    }
}

/// The same for a call that its caller may stop: it then ends with Stopped, whatever has failed.
template <class Work>
decltype(auto) guarded(const Control& control, Work&& work) {
    try {
        return guarded(std::forward<Work>(work));
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const Error&) {
        if (control.stop.stop_requested())
            throw Stopped("stopped");
        throw;
    }
}

}  // namespace terravox
