#pragma once

#include <pthread.h>

#include <functional>

#include "tests/catch.hpp"

namespace terravox::test {

/// What CivetWeb's threads have at least; what takes more of it ends the program.
inline constexpr std::size_t kSmallStack_bytes = 100 * 1024;

/// Runs work on a thread with so small a stack. It must not throw.
inline void on_small_stack(std::function<void()> work) {
    pthread_attr_t attributes;
    REQUIRE(pthread_attr_init(&attributes) == 0);
    REQUIRE(pthread_attr_setstacksize(&attributes, kSmallStack_bytes) == 0);
    const auto run = [](void* argument) -> void* {
        (*static_cast<std::function<void()>*>(argument))();
        return nullptr;
    };
    pthread_t thread{};
    REQUIRE(pthread_create(&thread, &attributes, run, &work) == 0);
    REQUIRE(pthread_join(thread, nullptr) == 0);
    pthread_attr_destroy(&attributes);
}

}  // namespace terravox::test
