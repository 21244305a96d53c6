/* Included before one of LASzip's sources (LASzip.cmake), whose functions call themselves as often as a damaged file says. A number thrown is
   how LASzip reports a damaged chunk. */
#ifndef TERRAVOX_LASZIP_GUARD_H
#define TERRAVOX_LASZIP_GUARD_H
namespace terravox_laszip {
class Call {
public:
    explicit Call(int& depth) : m_depth(depth) {
        constexpr int kDeepest = 8, kDamaged = 4711;
        if (m_depth >= kDeepest) throw kDamaged;
        ++m_depth;
    }
    ~Call() { --m_depth; }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

private:
    int& m_depth;
};
}
#define TERRAVOX_LASZIP_COUNT_CALL thread_local int terravox_depth = 0; const terravox_laszip::Call terravox_call(terravox_depth)
#endif
