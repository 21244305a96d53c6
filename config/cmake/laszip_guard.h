// Included before all of LASzip's sources: what protects it from damaged files and from missing
// memory (LASzip.cmake).
//
// What they allocate begins as zeros: LASzip makes thousands of objects for a file and fills arrays
// of pointers one by one; when memory ends on the way, its destructors delete all of them, and
// crash on those that nothing was written to.
#ifndef TERRAVOX_LASZIP_GUARD_H
#define TERRAVOX_LASZIP_GUARD_H

// All standard headers that LASzip includes, and those of placement new: the macro is not for them.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <istream>
#include <limits>
#include <map>
#include <memory>
#include <new>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <vector>

namespace terravox_laszip {

struct Zeroed {};

// A number thrown is how LASzip reports a damaged chunk.
constexpr int kDamaged = 4711;

class Call {
public:
    explicit Call(int& depth) : m_depth(depth) {
        constexpr int kDeepest = 8;
        if (m_depth >= kDeepest)
            throw kDamaged;
        ++m_depth;
    }
    ~Call() { --m_depth; }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

private:
    int& m_depth;
};

inline void check_value(unsigned value) {
    if (value == 0xFFFFFFFFU)
        throw kDamaged;
}

inline void* allocated(void* memory) {
    if (memory == nullptr)
        throw std::bad_alloc();
    return memory;
}

}  // namespace terravox_laszip

inline void* operator new(std::size_t bytes, terravox_laszip::Zeroed) {
    return std::memset(::operator new(bytes), 0, bytes);
}
inline void* operator new[](std::size_t bytes, terravox_laszip::Zeroed) {
    return std::memset(::operator new[](bytes), 0, bytes);
}
// For constructors that throw.
inline void operator delete(void* memory, terravox_laszip::Zeroed) noexcept {
    ::operator delete(memory);
}
inline void operator delete[](void* memory, terravox_laszip::Zeroed) noexcept {
    ::operator delete[](memory);
}

#define TERRAVOX_LASZIP_COUNT_CALL       \
    thread_local int terravox_depth = 0; \
    const terravox_laszip::Call terravox_call(terravox_depth)

#define new new (terravox_laszip::Zeroed{})

#endif
