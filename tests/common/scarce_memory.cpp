#include "tests/common/scarce_memory.hpp"

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>

namespace {

constexpr int kNoNullPointer = 0xA5;

std::atomic<bool> s_scarce = false;
std::atomic<std::int64_t> s_allocations_left = 0;

bool may_allocate() noexcept {
    return !s_scarce || s_allocations_left-- > 0;
}

void* allocate(std::size_t bytes) {
    void* const memory = std::malloc(bytes > 0 ? bytes : 1);
    if (memory == nullptr)
        throw std::bad_alloc();
    return memory;
}

}  // namespace

// The linker puts these in the place of the C library's functions (its option --wrap).
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): its names.
extern "C" {

void* __real_malloc(std::size_t bytes);
void* __real_calloc(std::size_t count, std::size_t bytes);
void* __real_realloc(void* memory, std::size_t bytes);

void* __wrap_malloc(std::size_t bytes) {
    void* const memory = may_allocate() ? __real_malloc(bytes) : nullptr;
    return memory != nullptr ? std::memset(memory, kNoNullPointer, bytes) : nullptr;
}
void* __wrap_calloc(std::size_t count, std::size_t bytes) {
    return may_allocate() ? __real_calloc(count, bytes) : nullptr;
}
void* __wrap_realloc(void* memory, std::size_t bytes) {
    return may_allocate() ? __real_realloc(memory, bytes) : nullptr;
}

}  // extern "C"
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

void* operator new(std::size_t bytes) {
    return allocate(bytes);
}
void* operator new[](std::size_t bytes) {
    return allocate(bytes);
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
    return std::malloc(bytes > 0 ? bytes : 1);
}
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept {
    return std::malloc(bytes > 0 ? bytes : 1);
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete[](void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, const std::nothrow_t&) noexcept {
    std::free(memory);
}
void operator delete[](void* memory, const std::nothrow_t&) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
    std::free(memory);
}

namespace terravox::test {

ScarceMemory::ScarceMemory(std::size_t allocations) noexcept {
    s_allocations_left = static_cast<std::int64_t>(allocations);
    s_scarce = true;
}

ScarceMemory::~ScarceMemory() {
    s_scarce = false;
}

}  // namespace terravox::test
