#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::net {

/// Both ends prove that they know the token without sending it. Before anything else on a
/// connection (docs/formats/farm-protocol.md):
///
///     dialler -> listener   hello:  8 bytes "TVX-FARM", 1 byte version, 32 random bytes
///     listener -> dialler   hello:  the same, of its own
///     dialler -> listener   proof:  HMAC-SHA-256(token, label of diallers | dialler's random
///                                   bytes | listener's)
///     listener -> dialler   answer: 1 byte verdict; proof: HMAC-SHA-256(token, label of
///                                   listeners | verdict | both random bytes)
///
/// A proof is not valid for another connection or direction. The dialler proves first: a program
/// that can reach a listener learns nothing that it could try tokens on. The answer's proof is
/// zeros where the verdict is a refusal. Nothing is encrypted, neither here nor later: an attacker
/// that can change packets on the way can take the connection over. Certificates protect against
/// that.
inline constexpr std::uint8_t kHandshakeVersion = 1;
inline constexpr std::string_view kHandshakeMagic = "TVX-FARM";
inline constexpr std::size_t kNonce_bytes = 32;
inline constexpr std::size_t kProof_bytes = 32;
inline constexpr std::size_t kHello_bytes = kHandshakeMagic.size() + 1 + kNonce_bytes;
inline constexpr std::size_t kAnswer_bytes = 1 + kProof_bytes;

enum class Verdict : std::uint8_t {
    kWelcome = 0,
    kWrongToken = 1,
    kBusy = 2,          ///< no room now
    kCertificates = 3,  ///< this listener accepts certificates, not tokens
};

using Bytes = std::vector<std::byte>;
using Nonce = std::array<std::byte, kNonce_bytes>;
using Proof = std::array<std::byte, kProof_bytes>;

/// The listener's side, without a socket. Not thread-safe.
class ListenerHandshake {
public:
    enum class Outcome {
        kMore,            ///< read wanted() more bytes
        kProven,          ///< the peer knows the token; send the answer()
        kWrongToken,      ///< send the answer()
        kNotTerravox,     ///< send nothing
        kAnotherVersion,  ///< the reply contains this side's version
    };
    struct Step {
        Outcome outcome = Outcome::kMore;
        Bytes reply;  ///< to be sent
    };
    /// @param token empty: no peer can know it
    explicit ListenerHandshake(std::string token);
    /// Number of bytes that may be read now: the bytes after the handshake belong to the next
    /// protocol.
    [[nodiscard]] std::size_t wanted() const noexcept {
        return (m_greeted ? kProof_bytes : kHello_bytes) - m_in.size();
    }
    /// @param bytes at most wanted()
    [[nodiscard]] Step take(std::span<const std::byte> bytes);
    [[nodiscard]] Bytes answer(Verdict verdict) const;
    [[nodiscard]] int version_of_peer() const noexcept { return m_version_of_peer; }

private:
    std::string m_token;
    Bytes m_in;
    Nonce m_theirs{};
    Nonce m_ours{};
    bool m_greeted = false;
    int m_version_of_peer = 0;
};

/// The dialler's side, without a socket. Not thread-safe.
class DiallerHandshake {
public:
    explicit DiallerHandshake(std::string token);
    [[nodiscard]] Bytes hello() const;
    /// @param hello of the listener
    /// @return the proof to send
    /// @throws RefusedError for one that is not of Terravox, or of another version
    [[nodiscard]] Bytes prove(std::span<const std::byte, kHello_bytes> hello);
    /// @throws RefusedError for a wrong token on either side, or where certificates are required;
    /// Error for a busy listener
    void check(std::span<const std::byte, kAnswer_bytes> answer) const;

private:
    std::string m_token;
    Nonce m_ours{};
    Nonce m_theirs{};
};

}  // namespace terravox::net
