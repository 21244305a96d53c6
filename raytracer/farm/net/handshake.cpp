#include "raytracer/farm/net/handshake.hpp"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>

#include <algorithm>
#include <cstring>

#include "raytracer/farm/net/endpoint.hpp"

namespace terravox::net {
namespace {

constexpr std::string_view kOfDialler = "terravox farm 1: dialler";
constexpr std::string_view kOfListener = "terravox farm 1: listener";

std::span<const std::byte> to_bytes(std::string_view text) {
    return std::as_bytes(std::span(text));
}

Proof make_proof(const std::string& token,
                 std::initializer_list<std::span<const std::byte>> parts) {
    Bytes message;
    for (const auto part : parts)
        message.insert(message.end(), part.begin(), part.end());
    Proof out{};
    unsigned size_bytes = 0;
    if (::HMAC(EVP_sha256(), token.data(), static_cast<int>(token.size()),
               reinterpret_cast<const unsigned char*>(message.data()), message.size(),
               reinterpret_cast<unsigned char*>(out.data()), &size_bytes) == nullptr ||
        size_bytes != out.size())
        throw util::Error("prove that the token is known: HMAC-SHA-256 failed");
    return out;
}

Bytes encode_hello(const Nonce& nonce) {
    Bytes out;
    const auto magic = to_bytes(kHandshakeMagic);
    out.insert(out.end(), magic.begin(), magic.end());
    out.push_back(std::byte{kHandshakeVersion});
    out.insert(out.end(), nonce.begin(), nonce.end());
    return out;
}

/// Whether the bytes so far could be the beginning of a hello.
bool begins_like_hello(std::span<const std::byte> bytes) {
    const auto magic = to_bytes(kHandshakeMagic);
    const auto size_bytes = std::min(bytes.size(), magic.size());
    return std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size_bytes),
                      magic.begin());
}

Nonce read_nonce(std::span<const std::byte> hello) {
    Nonce out{};
    std::copy_n(hello.begin() + static_cast<std::ptrdiff_t>(kHello_bytes - kNonce_bytes),
                kNonce_bytes, out.begin());
    return out;
}

Proof listener_proof(const std::string& token, Verdict verdict, const Nonce& dialler,
                     const Nonce& listener) {
    const std::array said{static_cast<std::byte>(verdict)};
    return make_proof(token, {to_bytes(kOfListener), said, dialler, listener});
}

/// @throws Error when the system has no random bytes
Nonce new_nonce() {
    Nonce out{};
    if (::RAND_bytes(reinterpret_cast<unsigned char*>(out.data()), static_cast<int>(out.size())) !=
        1)
        throw util::Error("shake hands with a peer: the system's random generator failed");
    return out;
}

}  // namespace

ListenerHandshake::ListenerHandshake(std::string token)
    : m_token(std::move(token)), m_ours(new_nonce()) {}

ListenerHandshake::Step ListenerHandshake::take(std::span<const std::byte> bytes) {
    m_in.insert(m_in.end(), bytes.begin(), bytes.end());
    if (!m_greeted) {
        if (!begins_like_hello(m_in))
            return {Outcome::kNotTerravox, {}};
        if (m_in.size() < kHello_bytes)
            return {};
        m_version_of_peer = std::to_integer<int>(m_in[kHandshakeMagic.size()]);
        m_theirs = read_nonce(m_in);
        m_in.clear();
        m_greeted = true;
        return {m_version_of_peer == kHandshakeVersion ? Outcome::kMore : Outcome::kAnotherVersion,
                encode_hello(m_ours)};
    }
    if (m_in.size() < kProof_bytes)
        return {};
    if (m_token.empty())
        return {Outcome::kWrongToken, {}};
    const Proof expected = make_proof(m_token, {to_bytes(kOfDialler), m_theirs, m_ours});
    const bool same = CRYPTO_memcmp(expected.data(), m_in.data(), kProof_bytes) == 0;
    return {same ? Outcome::kProven : Outcome::kWrongToken, {}};
}

Bytes ListenerHandshake::answer(Verdict verdict) const {
    Bytes out{static_cast<std::byte>(verdict)};
    const Proof proof =
        verdict == Verdict::kWelcome ? listener_proof(m_token, verdict, m_theirs, m_ours) : Proof{};
    out.insert(out.end(), proof.begin(), proof.end());
    return out;
}

DiallerHandshake::DiallerHandshake(std::string token)
    : m_token(std::move(token)), m_ours(new_nonce()) {}

Bytes DiallerHandshake::hello() const {
    return encode_hello(m_ours);
}

Bytes DiallerHandshake::prove(std::span<const std::byte, kHello_bytes> hello) {
    if (!begins_like_hello(hello))
        throw RefusedError("the peer is not a Terravox farm");
    if (const int version = std::to_integer<int>(hello[kHandshakeMagic.size()]);
        version != kHandshakeVersion)
        throw RefusedError("it uses handshake version " + std::to_string(version) +
                           "; allowed: " + std::to_string(kHandshakeVersion));
    m_theirs = read_nonce(hello);
    const Proof proof = make_proof(m_token, {to_bytes(kOfDialler), m_ours, m_theirs});
    return {proof.begin(), proof.end()};
}

void DiallerHandshake::check(std::span<const std::byte, kAnswer_bytes> answer) const {
    switch (static_cast<Verdict>(answer[0])) {
        case Verdict::kWelcome: {
            const Proof expected = listener_proof(m_token, Verdict::kWelcome, m_ours, m_theirs);
            if (CRYPTO_memcmp(expected.data(), answer.data() + 1, kProof_bytes) != 0)
                throw RefusedError("it does not know the token itself");
            return;
        }
        case Verdict::kWrongToken: throw RefusedError("wrong token");
        case Verdict::kBusy: throw util::Error("it has no room for another connection now");
        case Verdict::kCertificates: throw RefusedError("it takes certificates, and no token");
    }
    throw RefusedError("the peer is not a Terravox farm");
}

}  // namespace terravox::net
