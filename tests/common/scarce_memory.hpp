#pragma once

#include <cstddef>

namespace terravox::test {

/// While one exists, the process gets that many more allocations of memory, on all threads
/// together, and then none: malloc() and its like return null, operator new throws. What the C
/// library and other shared libraries allocate for themselves does not count.
/// For programs that CMake's terravox_scarce_memory(target) has been called for. In these, memory
/// that was allocated always begins with bytes that are no null pointer, as in a program that has
/// run for a while.
class ScarceMemory {
public:
    explicit ScarceMemory(std::size_t allocations) noexcept;
    ~ScarceMemory();
    ScarceMemory(const ScarceMemory&) = delete;
    ScarceMemory& operator=(const ScarceMemory&) = delete;
};

}  // namespace terravox::test
