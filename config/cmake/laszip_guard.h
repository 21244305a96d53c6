// Included before those of LASzip's sources that a damaged file or missing memory could crash
// (LASzip.cmake).
#ifndef TERRAVOX_LASZIP_GUARD_H
#define TERRAVOX_LASZIP_GUARD_H

#include <new>

namespace terravox_laszip {

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

#define TERRAVOX_LASZIP_COUNT_CALL       \
    thread_local int terravox_depth = 0; \
    const terravox_laszip::Call terravox_call(terravox_depth)

#endif
